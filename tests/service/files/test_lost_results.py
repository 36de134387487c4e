"""Registered results that the disk has lost: computed again, but never many at once."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from service.files.artifacts import Artifacts
from service.files.lost_results import Loss, ResultsLost, leave_list
from service.records.jobs import Cause, Kind, State, Submission, SweepState
from service.workers.attempt import Attempt
from tests.service.support.attempts import published
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.harness import AT_ONCE, Harness, open_harness


@pytest.fixture
def harness(tmp_path: Path) -> Iterator[Harness]:
    with open_harness(tmp_path, replace(AT_ONCE, lost_results_retry=0.0)) as opened:
        yield opened


def without_results(harness: Harness, ticket: Attempt, *numbers: int) -> None:
    """The publication says that it could not read the results of these runs."""
    Path(ticket.directory).mkdir(parents=True)
    found = {one["run_id"]: one for one in published(ticket)["outcomes"]}
    asked = [found[run_id(number)] for number in numbers]
    losses = [Loss(one["run_id"], str(one["path"]), str(one["sha256"])) for one in asked]
    with pytest.raises(ResultsLost) as told:
        leave_list(losses, Path(ticket.directory))
    harness.end_badly(ticket, Cause.ERROR, failure="ResultsLost", reason=str(told.value))


def computed(harness: Harness) -> None:
    """Work through the runs that are queued."""
    for ticket in harness.tick():
        harness.end_well(ticket)


def result_of(harness: Harness, number: int) -> Path:
    return Artifacts(harness.settings.data).path(harness.store.runs.file(run_id(number), "result.json"))


@pytest.mark.parametrize("damage", ["{}", None])
def test_lost_result__is_computed_again_for_the_next_sweep_that_shares_it(harness: Harness, damage: str | None) -> None:
    harness.submit(2)
    computed(harness)
    harness.publish()
    file = result_of(harness, 0)
    file.unlink() if damage is None else file.write_text(damage)

    row = harness.store.sweeps.create(Submission(sweep_of(2)))
    assert row.new == 0
    [publication] = harness.tick()
    without_results(harness, publication, 0)
    [again] = harness.tick()
    assert harness.store.sweeps.get(row.id).state is SweepState.RUNNING
    harness.end_well(again)
    harness.compute_all()
    assert harness.store.sweeps.get(row.id).state is SweepState.SUCCEEDED
    assert result_of(harness, 0).is_file()
    assert [harness.run(number).attempt for number in (0, 1)] == [2, 1]


@pytest.mark.parametrize("slots", [1, 2])
def test_lost_result__is_waited_for_by_a_sweep_whose_publication_is_due_or_under_way(
    harness: Harness, slots: int
) -> None:
    harness.engine.free = slots
    [run] = harness.begin(1)
    harness.submit(1)
    harness.end_well(run)
    [publication, *others] = harness.tick()
    result_of(harness, 0).unlink()
    without_results(harness, publication, 0)
    [again] = harness.tick()
    for attempt in (*others, again):
        harness.end_well(attempt)
    harness.engine.free = 2
    publications = harness.tick()
    assert [one["state"] for publication in publications for one in published(publication)["outcomes"]] == [
        State.SUCCEEDED
    ] * 2


def test_lost_result__that_is_there_for_the_service_costs_nothing(harness: Harness) -> None:
    harness.submit(1)
    computed(harness)
    [publication] = harness.tick()
    without_results(harness, publication, 0)
    [again] = harness.tick()
    assert again.kind is Kind.PUBLISH
    assert harness.run().attempt == 1


def test_lost_result__fails_its_run_when_it_is_lost_for_the_third_time(harness: Harness) -> None:
    row = harness.store.sweeps.create(Submission(sweep_of(1)))
    for _ in range(3):
        computed(harness)
        [publication] = harness.tick()
        result_of(harness, 0).unlink()
        without_results(harness, publication, 0)
    harness.publish()
    run = harness.run()
    assert (run.state, run.cause) == (State.FAILED, Cause.ERROR)
    assert "lost or damaged" in str(run.reason)
    assert harness.store.sweeps.get(row.id).state is SweepState.SUCCEEDED


@pytest.fixture
def large(harness: Harness) -> Harness:
    """A service with eight results, which does not wait before it looks for lost ones again."""
    harness.engine.free = 8
    harness.submit(8)
    computed(harness)
    harness.publish()
    return harness


def shared(harness: Harness, *numbers: int) -> Attempt:
    """The publication of a sweep that shares these runs."""
    harness.store.sweeps.create(Submission(sweep_of(runs_of(*["fine"] * len(numbers), first=numbers[0]))))
    [publication] = harness.tick()
    return publication


def lose(harness: Harness, publication: Attempt, *numbers: int) -> list[Attempt]:
    """A publication finds that the results of these runs are gone; what is begun then."""
    for number in numbers:
        result_of(harness, number).unlink(missing_ok=True)
    without_results(harness, publication, *numbers)
    return harness.tick()


def test_many_lost_results__are_named_and_none_is_forgotten(large: Harness, caplog: pytest.LogCaptureFixture) -> None:
    large.store.sweeps.create(Submission(sweep_of(runs_of("fine", first=90), name="another")))
    large.store.queue.pause()
    publication = shared(large, *range(6))
    large.store.queue.resume()
    [again] = lose(large, publication, *range(6))  # and no run of the other sweep
    assert again.kind is Kind.PUBLISH
    blocked_reason = str(large.store.queue.status().blocked_reason)
    assert blocked_reason.startswith("6 of 8 registered results are lost or damaged")
    assert f"{run_id(0)}, {run_id(1)}, {run_id(2)} and 3 more" in blocked_reason
    assert blocked_reason.endswith("`whipple doctor --forget-lost 6`")
    assert all(any(run_id(number) in line for line in caplog.messages) for number in range(6))
    assert all(large.run(number).sha256 for number in range(6))


def test_many_lost_results__stop_no_run_for_which_their_publication_waits(large: Harness) -> None:
    publication = shared(large, *range(6))
    large.engine.free = 0
    assert lose(large, publication, *range(6)) == []
    assert large.store.publications.mend(large.store.runs.file(run_id(0), "result.json"), most=3)
    large.engine.free = 8
    [again] = large.tick()
    assert (again.kind, again.run) == (Kind.RUN, run_id(0))


def test_many_lost_results__are_computed_again_when_people_allow_it(large: Harness) -> None:
    [again] = lose(large, shared(large, *range(6)), *range(6))
    large.store.queue.allow_forgetting(6)
    assert len(lose(large, again, *range(6))) == 6
    assert large.store.queue.status().blocked_reason is None
