"""Registered results that the disk has lost: computed again, but never many at once."""

from collections.abc import Iterator
from datetime import timedelta
from pathlib import Path

import pytest

from service.files.artifacts import Artifacts
from service.files.lost_results import Loss, ResultsLost, leave_list
from service.records.attempt import Ticket
from service.records.jobs import Cause, Kind, State, SweepState
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.stepped_dispatcher import Bench, open_bench


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_bench(tmp_path) as opened:
        yield opened


def without_results(bench: Bench, ticket: Ticket, *numbers: int) -> None:
    """The publication says that it could not read the results of these runs."""
    Path(ticket.directory).mkdir(parents=True)
    found = {one["run_id"]: one for one in ticket.spec["outcomes"]}
    asked = [found[run_id(number)] for number in numbers]
    losses = [Loss(one["run_id"], one["path"], one["sha256"]) for one in asked]
    with pytest.raises(ResultsLost) as told:
        leave_list(losses, Path(ticket.directory))
    bench.end_badly(ticket, Cause.ERROR, failure="ResultsLost", reason=str(told.value))


def computed(bench: Bench) -> None:
    """Work through the runs that are queued."""
    for ticket in bench.turn():
        bench.end_well(ticket)


def result_of(bench: Bench, number: int) -> Path:
    return Artifacts(bench.settings.data).path(bench.store.run_file(run_id(number), "result.json"))


@pytest.mark.parametrize("damage", ["{}", None])
def test_lost_result__is_computed_again_for_the_next_sweep_that_shares_it(
    bench: Bench, damage: str | None
) -> None:
    bench.store.create_sweep(sweep_of(2))
    computed(bench)
    [publication] = bench.turn()
    bench.end_well(publication)
    bench.turn()
    file = result_of(bench, 0)
    file.unlink() if damage is None else file.write_text(damage)

    row = bench.store.create_sweep(sweep_of(2))
    assert row.new == 0
    [publication] = bench.turn()
    without_results(bench, publication, 0)
    [again] = bench.turn()
    assert bench.store.sweep(row.id).state is SweepState.RUNNING
    bench.end_well(again)
    [publication] = bench.turn()
    bench.end_well(publication)
    bench.turn()
    assert bench.store.sweep(row.id).state is SweepState.SUCCEEDED
    assert result_of(bench, 0).is_file()
    assert [bench.run(number).attempt for number in (0, 1)] == [2, 1]


def test_lost_result__that_is_there_for_the_service_costs_nothing(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    computed(bench)
    [publication] = bench.turn()
    without_results(bench, publication, 0)
    [again] = bench.turn()
    assert again.kind is Kind.PUBLISH
    assert bench.run().attempt == 1


def test_lost_result__fails_its_run_when_it_is_lost_for_the_third_time(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(1))
    for _ in range(3):
        computed(bench)
        [publication] = bench.turn()
        result_of(bench, 0).unlink()
        without_results(bench, publication, 0)
    [publication] = bench.turn()
    bench.end_well(publication)
    bench.turn()
    run = bench.run()
    assert (run.state, run.cause) == (State.FAILED, Cause.ERROR)
    assert "lost or damaged" in str(run.reason)
    assert bench.store.sweep(row.id).state is SweepState.SUCCEEDED


def test_lost_result__of_a_cancelled_sweep_is_not_computed(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(2))
    tickets = bench.turn()
    bench.end_well(next(one for one in tickets if one.spec["id"] == run_id(0)))
    bench.turn()
    bench.store.cancel_sweep(row.id)
    for ticket in tickets:
        if ticket.spec["id"] == run_id(1):
            bench.end_badly(ticket, Cause.LOST)
    [publication] = [one for one in bench.turn() if one.kind is Kind.PUBLISH]
    result_of(bench, 0).unlink()
    without_results(bench, publication, 0)
    [publication] = bench.turn()
    bench.end_well(publication)
    bench.turn()
    assert bench.store.sweep(row.id).state is SweepState.CANCELLED


# --- limits ----------------------------------------------------------------------------------------


@pytest.fixture
def large(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> Bench:
    """A service with eight results, which does not wait before it looks for lost ones again."""
    monkeypatch.setattr("service.queue.registration.REFUSED_SECONDS", 0.0)
    bench.engine.free = 8
    bench.store.create_sweep(sweep_of(8))
    computed(bench)
    [publication] = bench.turn()
    bench.end_well(publication)
    bench.turn()
    return bench


def shared(bench: Bench, *numbers: int) -> Ticket:
    """The publication of a sweep that shares these runs."""
    bench.store.create_sweep(sweep_of(runs_of(*["fine"] * len(numbers), first=numbers[0])))
    [publication] = bench.turn()
    return publication


def lose(bench: Bench, publication: Ticket, *numbers: int) -> list[Ticket]:
    """A publication finds that the results of these runs are gone; what is begun then."""
    for number in numbers:
        result_of(bench, number).unlink(missing_ok=True)
    without_results(bench, publication, *numbers)
    return bench.turn()


def test_many_lost_results__are_named_and_none_is_forgotten(
    large: Bench, caplog: pytest.LogCaptureFixture
) -> None:
    large.store.create_sweep(sweep_of(runs_of("fine", first=90), name="another"))
    large.store.pause()
    publication = shared(large, *range(6))
    large.store.resume()
    [again] = lose(large, publication, *range(6))  # and no run of the other sweep
    assert again.kind is Kind.PUBLISH
    hindrance = str(large.store.queue().hindrance)
    assert hindrance.startswith("6 of 8 registered results are lost or damaged")
    assert f"{run_id(0)}, {run_id(1)}, {run_id(2)} and 3 more" in hindrance
    assert hindrance.endswith("`whipple forget-lost 6`")
    assert all(any(run_id(number) in line for line in caplog.messages) for number in range(6))
    assert all(large.run(number).path for number in range(6))


def test_many_lost_results__that_are_there_again_are_published(large: Bench) -> None:
    files = [result_of(large, number) for number in range(6)]
    content = [file.read_bytes() for file in files]
    [again] = lose(large, shared(large, *range(6)), *range(6))
    for file, was in zip(files, content, strict=True):
        file.write_bytes(was)
    large.end_well(again)
    large.turn()
    assert large.store.queue().hindrance is None
    assert large.store.queue().states == {State.SUCCEEDED: 10}
    assert [large.run(number).attempt for number in range(6)] == [1] * 6


def test_many_lost_results__are_computed_again_when_people_allow_it(large: Bench) -> None:
    [again] = lose(large, shared(large, *range(6)), *range(6))
    large.store.allow_forgetting(6)
    assert len(lose(large, again, *range(6))) == 6
    assert large.store.queue().hindrance is None


def test_few_lost_results__again_and_again_are_no_more_than_a_share_of_all(
    large: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("service.store.losses.AT_ONCE", timedelta(0))
    assert len(lose(large, shared(large, 0, 1, 2), 0, 1, 2)) == 3
    [again] = lose(large, shared(large, 4, 5, 6), 4, 5, 6)
    assert again.kind is Kind.PUBLISH
    assert "5 a day" in str(large.store.queue().hindrance)
    monkeypatch.setattr("service.store.losses.MOST_OF_ALL", 1.2)  # of the five that are left
    assert len(lose(large, again, 4, 5, 6)) == 3
