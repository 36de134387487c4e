"""Another life, another leader, an engine that was away: rows and engine are compared."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from service.records.attempt import Away, Back, Ended
from service.records.jobs import Cause, Claim, State, StoreUnavailable, SweepState
from tests.service.support.fakes import StandStill, run_id, sweep_of
from tests.service.support.stepped_dispatcher import Bench, open_bench


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_bench(tmp_path) as opened:
        yield opened


def test_new_life__what_ran_is_queued_again_at_once(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(2))
    bench.turn()
    engine = StandStill()
    bench.successor(engine).turn()
    assert [ticket.key.split("-")[1] for ticket in engine.submitted] == ["2", "2"]
    assert bench.run().crashes == 0


def test_new_life__a_complete_result_is_not_computed_twice(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(2))
    done, _ = bench.turn()
    bench.compute(done)
    engine = StandStill()
    bench.successor(engine).turn()
    run = bench.run()
    assert (run.state, run.attempt, run.seconds) == (State.SUCCEEDED, 1, 0.5)
    assert len(bench.store.run_files(run_id(0))) == 3
    assert len(engine.submitted) == 1


def test_new_life__a_result_without_its_answer_is_computed_again(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.compute(ticket)
    (Path(ticket.directory) / "result.json").rename(Path(ticket.directory) / ".result.json.x.part")
    engine = StandStill()
    bench.successor(engine).turn()
    assert len(engine.submitted) == 1


def test_lost__a_result_that_is_complete_on_disk_counts(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.compute(ticket)
    bench.end_badly(ticket, Cause.LOST)  # its worker died just then
    bench.turn()
    run = bench.run()
    assert (run.state, run.attempt, run.seconds) == (State.SUCCEEDED, 1, 0.5)


def test_new_reign__a_store_that_is_away_at_its_begin_loses_no_result(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away() -> tuple[Claim, ...]:
        raise StoreUnavailable("locked")

    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.end_well(ticket)
    bench.dispatcher._reign = None  # the right to lead was lost, and found again
    with monkeypatch.context() as patch:
        patch.setattr(bench.store, "claimed", away)
        with pytest.raises(StoreUnavailable):
            bench.turn()
    bench.turn()
    assert (bench.run().state, bench.run().attempt) == (State.SUCCEEDED, 1)


def test_new_life__a_publication_is_made_again(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(1))
    bench.end_well(bench.turn()[0])
    [publication] = bench.turn()
    bench.compute(publication)
    engine = StandStill()
    successor = bench.successor(engine)
    successor.turn()
    [again] = engine.submitted
    assert again.directory != publication.directory
    bench.end_well(again)
    successor.turn()
    assert bench.store.sweep(row.id).state is SweepState.SUCCEEDED


def test_new_life__a_run_that_was_being_cancelled_ends_cancelled(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(1))
    bench.turn()
    bench.store.cancel_sweep(row.id)
    engine = StandStill()
    bench.successor(engine).turn()
    assert bench.run().state is State.CANCELLED
    assert engine.submitted == []


def test_compare__leaves_alone_what_is_under_way(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(2))
    for _ in range(4):
        bench.turn()
    assert bench.run().attempt == 1
    assert bench.engine.stopped == []


# --- an engine that outlives us --------------------------------------------------------------------


def test_adoption__what_the_engine_still_has_goes_on(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(2))
    one, other = bench.turn()
    engine = StandStill(under_way={one.key, other.key})
    successor = bench.successor(engine)
    successor.turn()
    assert sorted(engine.followed) == sorted([one.key, other.key])
    assert engine.submitted == []
    bench.end_well(one)
    successor.turn()
    assert (bench.run().state, bench.run().attempt) == (State.SUCCEEDED, 1)
    assert one.key in engine.forgotten


def test_adoption__a_second_change_of_leader_finds_it_too(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    for _ in range(2):
        engine = StandStill(under_way={ticket.key})
        successor = bench.successor(engine)
        successor.turn()
        assert engine.followed == [ticket.key]
    bench.end_well(ticket)
    successor.turn()
    assert (bench.run().state, bench.run().attempt) == (State.SUCCEEDED, 1)


def test_adoption__the_leader_of_before_can_no_longer_say_anything(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(3))
    one, _ = bench.turn()
    own = bench.inbox
    assert own is not None
    engine = StandStill(under_way={one.key})
    bench.successor(engine).turn()
    own.put(Ended(one.key, bench.compute(one)))
    assert bench.turn() == []  # neither the end counts nor is anything claimed
    assert bench.run().state is State.RUNNING


def test_adoption__fills_slots(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(4))
    one, _ = bench.turn()
    engine = StandStill(under_way={one.key})
    bench.successor(engine).turn()
    assert len(engine.submitted) == 1


def test_adoption__of_a_run_that_is_being_cancelled_ends_it(bench: Bench) -> None:
    row = bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    bench.store.cancel_sweep(row.id)
    engine = StandStill(under_way={ticket.key})
    successor = bench.successor(engine)
    successor.turn()
    assert engine.stopped == [ticket.key]
    bench.end_badly(ticket, Cause.LOST)
    successor.turn()
    assert bench.run().state is State.CANCELLED


def test_strangers__of_ours_are_stopped_and_those_of_others_let_alone(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    Path(ticket.directory).mkdir(parents=True)
    bench.end_badly(ticket, Cause.LOST)
    bench.turn()
    foreign = f"{run_id(9)}-1-c0ffee00"
    bench.engine.under_way = {ticket.key, foreign, "x"}
    bench.turn()
    assert bench.engine.stopped == [ticket.key]
    assert bench.engine.followed == [ticket.key]


def test_strangers__are_stopped_again_until_they_have_ended(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    [ticket] = bench.turn()
    Path(ticket.directory).mkdir(parents=True)
    bench.end_badly(ticket, Cause.LOST)
    [again] = bench.turn()
    bench.engine.under_way = {ticket.key, again.key}
    bench.engine.forgotten.clear()
    for _ in range(3):
        bench.turn()
    assert bench.engine.stopped == [ticket.key] * 3
    assert bench.engine.forgotten == []
    bench.end_badly(ticket, Cause.LOST)
    for _ in range(2):
        bench.turn()
    assert bench.engine.stopped == [ticket.key] * 3
    assert bench.engine.forgotten == [ticket.key]
    assert bench.engine.under_way == {again.key}
    assert bench.run().attempt == 2


def test_strangers__a_publication_that_no_longer_counts_is_stopped(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    bench.end_well(bench.turn()[0])
    [publication] = bench.turn()
    Path(publication.directory).mkdir(parents=True)
    bench.end_badly(publication, Cause.LOST)
    bench.turn()
    bench.engine.under_way = {publication.key}
    bench.turn()
    assert bench.engine.stopped == [publication.key]


# --- a scheduler that is away ------------------------------------------------------------------------


def test_away__nothing_is_claimed_and_the_state_says_why(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(1))
    bench.store.pause()
    bench.turn()
    bench.say(Away("the scheduler does not answer"))
    bench.store.resume()
    assert bench.turn() == []
    assert bench.dispatcher.trouble() == "the scheduler does not answer"
    assert bench.store.queue().hindrance == "the scheduler does not answer"
    bench.say(Back())
    assert len(bench.turn()) == 1
    assert bench.store.queue().hindrance is None


def test_away__costs_what_was_under_way_nothing(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(2))
    one, other = bench.turn()
    bench.say(Away("the scheduler does not answer"))
    for _ in range(3):
        bench.turn()
    assert (bench.run(0).attempt, bench.run(1).attempt) == (1, 1)
    bench.say(Back())
    bench.end_badly(other, Cause.LOST)  # this one was lost with it
    bench.end_well(one)
    bench.turn()
    assert (bench.run(0).state, bench.run(0).attempt) == (State.SUCCEEDED, 1)
    assert (bench.run(1).attempt, bench.run(1).crashes) == (2, 0)


def test_away__at_the_start_nothing_is_decided_about_earlier_attempts(bench: Bench) -> None:
    bench.store.create_sweep(sweep_of(2))
    one, _ = bench.turn()
    engine = StandStill(free=0, under_way={one.key})
    successor = bench.successor(engine, first=Away("the scheduler has not answered yet"))
    for _ in range(3):
        successor.turn()
    assert {bench.run(number).attempt for number in (0, 1)} == {1}
    assert successor.trouble() == "the scheduler has not answered yet"
    engine.free = 2
    bench.say(Back())
    successor.turn()
    assert engine.followed == [one.key]
    assert [ticket.key.split("-")[1] for ticket in engine.submitted] == ["2"]
