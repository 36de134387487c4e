"""Another life, another leader, an engine that was away: rows and engine are compared."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from service.records.attempt import Away, Back, Ended
from service.records.jobs import Cause, Claim, State, StoreUnavailable, SweepState
from tests.service.support.fakes import RecordingEngine, run_id, sweep_of
from tests.service.support.harness import Harness, open_harness


@pytest.fixture
def harness(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Harness]:
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_harness(tmp_path) as opened:
        yield opened


def test_new_life__what_ran_is_queued_again_at_once(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(2))
    harness.turn()
    engine = RecordingEngine()
    harness.successor(engine).turn()
    assert [ticket.key.split("-")[1] for ticket in engine.submitted] == ["2", "2"]
    assert harness.run().crashes == 0


def test_new_life__a_complete_result_is_not_computed_twice(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(2))
    done, _ = harness.turn()
    harness.compute(done)
    engine = RecordingEngine()
    harness.successor(engine).turn()
    run = harness.run()
    assert (run.state, run.attempt, run.seconds) == (State.SUCCEEDED, 1, 0.5)
    assert len(harness.store.run_files(run_id(0))) == 3
    assert len(engine.submitted) == 1


def test_new_life__a_result_without_its_answer_is_computed_again(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.compute(ticket)
    (Path(ticket.directory) / "result.json").rename(Path(ticket.directory) / ".result.json.x.part")
    engine = RecordingEngine()
    harness.successor(engine).turn()
    assert len(engine.submitted) == 1


def test_lost__a_result_that_is_complete_on_disk_counts(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.compute(ticket)
    harness.end_badly(ticket, Cause.LOST)  # its worker died just then
    harness.turn()
    run = harness.run()
    assert (run.state, run.attempt, run.seconds) == (State.SUCCEEDED, 1, 0.5)


def test_new_reign__a_store_that_is_away_at_its_begin_loses_no_result(
    harness: Harness, monkeypatch: pytest.MonkeyPatch
) -> None:
    def away() -> tuple[Claim, ...]:
        raise StoreUnavailable("locked")

    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.end_well(ticket)
    harness.dispatcher._reign = None  # the right to lead was lost, and found again
    with monkeypatch.context() as patch:
        patch.setattr(harness.store, "claimed", away)
        with pytest.raises(StoreUnavailable):
            harness.turn()
    harness.turn()
    assert (harness.run().state, harness.run().attempt) == (State.SUCCEEDED, 1)


def test_new_life__a_publication_is_made_again(harness: Harness) -> None:
    row = harness.store.create_sweep(sweep_of(1))
    harness.end_well(harness.turn()[0])
    [publication] = harness.turn()
    harness.compute(publication)
    engine = RecordingEngine()
    successor = harness.successor(engine)
    successor.turn()
    [again] = engine.submitted
    assert again.directory != publication.directory
    harness.end_well(again)
    successor.turn()
    assert harness.store.sweep(row.id).state is SweepState.SUCCEEDED


def test_new_life__a_run_that_was_being_cancelled_ends_cancelled(harness: Harness) -> None:
    row = harness.store.create_sweep(sweep_of(1))
    harness.turn()
    harness.store.cancel_sweep(row.id)
    engine = RecordingEngine()
    harness.successor(engine).turn()
    assert harness.run().state is State.CANCELLED
    assert engine.submitted == []


def test_compare__leaves_alone_what_is_under_way(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(2))
    for _ in range(4):
        harness.turn()
    assert harness.run().attempt == 1
    assert harness.engine.stopped == []


# --- an engine that outlives us --------------------------------------------------------------------


def test_adoption__what_the_engine_still_has_goes_on(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(2))
    one, other = harness.turn()
    engine = RecordingEngine(under_way={one.key, other.key})
    successor = harness.successor(engine)
    successor.turn()
    assert sorted(engine.followed) == sorted([one.key, other.key])
    assert engine.submitted == []
    harness.end_well(one)
    successor.turn()
    assert (harness.run().state, harness.run().attempt) == (State.SUCCEEDED, 1)
    assert one.key in engine.forgotten


def test_adoption__a_second_change_of_leader_finds_it_too(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    for _ in range(2):
        engine = RecordingEngine(under_way={ticket.key})
        successor = harness.successor(engine)
        successor.turn()
        assert engine.followed == [ticket.key]
    harness.end_well(ticket)
    successor.turn()
    assert (harness.run().state, harness.run().attempt) == (State.SUCCEEDED, 1)


def test_adoption__the_leader_of_before_can_no_longer_say_anything(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(3))
    one, _ = harness.turn()
    own = harness.inbox
    assert own is not None
    engine = RecordingEngine(under_way={one.key})
    harness.successor(engine).turn()
    own.put(Ended(one.key, harness.compute(one)))
    assert harness.turn() == []  # neither the end counts nor is anything claimed
    assert harness.run().state is State.RUNNING


def test_adoption__fills_slots(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(4))
    one, _ = harness.turn()
    engine = RecordingEngine(under_way={one.key})
    harness.successor(engine).turn()
    assert len(engine.submitted) == 1


def test_adoption__of_a_run_that_is_being_cancelled_ends_it(harness: Harness) -> None:
    row = harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    harness.store.cancel_sweep(row.id)
    engine = RecordingEngine(under_way={ticket.key})
    successor = harness.successor(engine)
    successor.turn()
    assert engine.stopped == [ticket.key]
    harness.end_badly(ticket, Cause.LOST)
    successor.turn()
    assert harness.run().state is State.CANCELLED


def test_strangers__of_ours_are_stopped_and_those_of_others_let_alone(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    Path(ticket.directory).mkdir(parents=True)
    harness.end_badly(ticket, Cause.LOST)
    harness.turn()
    foreign = f"{run_id(9)}-1-c0ffee00"
    harness.engine.under_way = {ticket.key, foreign, "x"}
    harness.turn()
    assert harness.engine.stopped == [ticket.key]
    assert harness.engine.followed == [ticket.key]


def test_strangers__are_stopped_again_until_they_have_ended(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    [ticket] = harness.turn()
    Path(ticket.directory).mkdir(parents=True)
    harness.end_badly(ticket, Cause.LOST)
    [again] = harness.turn()
    harness.engine.under_way = {ticket.key, again.key}
    harness.engine.forgotten.clear()
    for _ in range(3):
        harness.turn()
    assert harness.engine.stopped == [ticket.key] * 3
    assert harness.engine.forgotten == []
    harness.end_badly(ticket, Cause.LOST)
    for _ in range(2):
        harness.turn()
    assert harness.engine.stopped == [ticket.key] * 3
    assert harness.engine.forgotten == [ticket.key]
    assert harness.engine.under_way == {again.key}
    assert harness.run().attempt == 2


def test_strangers__a_publication_that_no_longer_counts_is_stopped(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    harness.end_well(harness.turn()[0])
    [publication] = harness.turn()
    Path(publication.directory).mkdir(parents=True)
    harness.end_badly(publication, Cause.LOST)
    harness.turn()
    harness.engine.under_way = {publication.key}
    harness.turn()
    assert harness.engine.stopped == [publication.key]


# --- a scheduler that is away ------------------------------------------------------------------------


def test_away__nothing_is_claimed_and_the_state_says_why(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(1))
    harness.store.pause()
    harness.turn()
    harness.say(Away("the scheduler does not answer"))
    harness.store.resume()
    assert harness.turn() == []
    assert harness.dispatcher.trouble() == "the scheduler does not answer"
    assert harness.store.queue().hindrance == "the scheduler does not answer"
    harness.say(Back())
    assert len(harness.turn()) == 1
    assert harness.store.queue().hindrance is None


def test_away__costs_what_was_under_way_nothing(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(2))
    one, other = harness.turn()
    harness.say(Away("the scheduler does not answer"))
    for _ in range(3):
        harness.turn()
    assert (harness.run(0).attempt, harness.run(1).attempt) == (1, 1)
    harness.say(Back())
    harness.end_badly(other, Cause.LOST)  # this one was lost with it
    harness.end_well(one)
    harness.turn()
    assert (harness.run(0).state, harness.run(0).attempt) == (State.SUCCEEDED, 1)
    assert (harness.run(1).attempt, harness.run(1).crashes) == (2, 0)


def test_away__at_the_start_nothing_is_decided_about_earlier_attempts(harness: Harness) -> None:
    harness.store.create_sweep(sweep_of(2))
    one, _ = harness.turn()
    engine = RecordingEngine(free=0, under_way={one.key})
    successor = harness.successor(engine, first=Away("the scheduler has not answered yet"))
    for _ in range(3):
        successor.turn()
    assert {harness.run(number).attempt for number in (0, 1)} == {1}
    assert successor.trouble() == "the scheduler has not answered yet"
    engine.free = 2
    harness.say(Back())
    successor.turn()
    assert engine.followed == [one.key]
    assert [ticket.key.split("-")[1] for ticket in engine.submitted] == ["2"]
