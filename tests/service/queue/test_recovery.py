"""Another life, another leader, an engine that was away: rows and engine are compared."""

from pathlib import Path

import pytest

from service.records.jobs import Cause
from service.workers.attempt import Attempt, Away, Back
from tests.service.support.fakes import RecordingEngine, run_id
from tests.service.support.harness import Harness

AWAY = "the scheduler does not answer"


def attempt_numbers(engine: RecordingEngine) -> list[str]:
    return [attempt.key.split("-")[1] for attempt in engine.submitted]


def test_new_life__registers_what_is_complete_and_queues_the_rest(harness: Harness) -> None:
    harness.engine.free = 3
    complete, half, _none = harness.begin(3)
    harness.compute(complete)
    harness.compute(half)
    result = Path(half.directory) / "result.json"
    result.rename(result.with_name(".result.json.x.part"))
    engine = RecordingEngine()
    harness.successor(engine).tick()
    assert harness.is_first_success()
    assert harness.run().seconds == 0.5
    assert len(harness.store.runs.files(run_id(0))) == 3
    assert attempt_numbers(engine) == ["2", "2"]
    assert harness.run(1).crashes == 0


def test_adoption__attempts_go_on_through_changes_of_leader(harness: Harness) -> None:
    first, second = harness.begin(3)
    for _ in range(2):
        engine = RecordingEngine(under_way={first.key, second.key})
        successor = harness.successor(engine)
        successor.tick()
        assert sorted(engine.followed) == sorted([first.key, second.key])
        assert engine.submitted == []
    harness.end_well(first)
    successor.tick()
    assert harness.is_first_success()
    assert first.key in engine.forgotten
    assert len(engine.submitted) == 1  # in the free slot


def lost(harness: Harness, attempt: Attempt) -> None:
    """Let an attempt be lost, whose folder stays."""
    Path(attempt.directory).mkdir(parents=True)
    harness.end_badly(attempt, Cause.LOST)


@pytest.mark.parametrize("is_publication", [False, True])
def test_foreign_attempt__of_ours_is_stopped_until_it_ends_and_those_of_others_go_on(
    harness: Harness, is_publication: bool
) -> None:
    [attempt] = harness.begin(1)
    if is_publication:
        harness.end_well(attempt)
        [attempt] = harness.tick()
    lost(harness, attempt)
    [again] = harness.tick()
    harness.engine.under_way = {attempt.key, again.key, f"{run_id(9)}-1-c0ffee00", "x"}
    harness.engine.forgotten.clear()
    for _ in range(3):
        harness.tick()
    assert harness.engine.stopped == [attempt.key] * 3
    assert harness.engine.followed == [attempt.key]
    assert harness.engine.forgotten == []
    harness.end_badly(attempt, Cause.LOST)
    harness.tick()
    harness.tick()
    assert harness.engine.stopped == [attempt.key] * 3
    assert harness.engine.forgotten == [attempt.key]


def test_away__costs_what_was_under_way_nothing(harness: Harness) -> None:
    first, second = harness.begin(2)
    harness.send(Away(AWAY))
    for _ in range(3):
        harness.tick()
    assert (harness.run(0).attempt, harness.run(1).attempt) == (1, 1)
    harness.send(Back())
    harness.end_badly(second, Cause.LOST)  # with the scheduler
    harness.end_well(first)
    harness.tick()
    assert harness.is_first_success()
    assert (harness.run(1).attempt, harness.run(1).crashes) == (2, 0)


def test_away__at_the_start_nothing_is_decided_about_earlier_attempts(harness: Harness) -> None:
    first, _ = harness.begin(2)
    engine = RecordingEngine(free=0, under_way={first.key})
    successor = harness.successor(engine, first=Away(AWAY))
    for _ in range(3):
        successor.tick()
    assert {harness.run(number).attempt for number in (0, 1)} == {1}
    assert successor.blocked_reason() == AWAY
    engine.free = 2
    harness.send(Back())
    successor.tick()
    assert engine.followed == [first.key]
    assert attempt_numbers(engine) == ["2"]
