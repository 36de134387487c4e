"""The leader's ticks: slots are filled, what nobody wants is stopped, progress is written."""

from dataclasses import replace
from pathlib import Path

import pytest

from service.queue.leader import NO_WORKER, REFUSED
from service.records.jobs import AttemptProgress, Cause, Kind, State
from service.workers.attempt import ProgressMessage
from tests.service.support.fakes import runs_of
from tests.service.support.harness import AT_ONCE, Harness, open_harness


def test_fill__never_more_than_the_free_slots(harness: Harness) -> None:
    assert len(harness.begin(6)) == 2
    assert harness.tick() == []
    harness.end_well(harness.engine.submitted[0])
    assert len(harness.tick()) == 1
    harness.engine.free = 1  # a worker has gone
    harness.end_well(harness.engine.submitted[1])
    assert harness.tick() == []


def test_fill__nothing_without_worker_or_while_paused(harness: Harness) -> None:
    harness.engine.free = 0
    assert harness.begin(1) == []
    assert harness.dispatcher.workers() == 0
    assert harness.dispatcher.blocked_reason() == NO_WORKER
    harness.engine.free = 2
    harness.store.queue.pause()
    assert harness.tick() == []
    harness.store.queue.resume()
    assert len(harness.tick()) == 1


def test_fill__an_engine_that_refuses_costs_the_run_nothing(tmp_path: Path) -> None:
    with open_harness(tmp_path, replace(AT_ONCE, engine_retry=3600.0)) as harness:
        harness.engine.refuses = True
        harness.begin(1)
        harness.engine.refuses = False
        assert harness.tick() == []
        assert harness.dispatcher.blocked_reason() == REFUSED
    with open_harness(tmp_path, replace(AT_ONCE, engine_retry=0.0)) as harness:
        assert len(harness.tick()) == 1
        assert harness.run().crashes == 0


def test_fill__a_search_that_fails_holds_up_no_other_job(harness: Harness, monkeypatch: pytest.MonkeyPatch) -> None:
    [first] = harness.begin(1)
    harness.end_well(first)
    harness.engine.free = 0
    harness.tick()
    harness.engine.free = 2
    with monkeypatch.context() as patched:
        patched.delattr("service.queue.searching.goes_on")
        [run] = harness.begin(runs_of("fine", first=1))
    assert (run.kind, harness.dispatcher.blocked_reason()) == (Kind.RUN, None)
    [publication] = harness.tick()
    assert publication.kind is Kind.PUBLISH


def test_cancel__is_asked_for_until_the_attempt_has_ended(harness: Harness) -> None:
    id = harness.submit(1)
    [attempt] = harness.tick()
    harness.store.sweeps.cancel(id)
    harness.tick()
    harness.tick()
    assert harness.engine.stopped == [attempt.key] * 2
    harness.end_badly(attempt, Cause.LOST)
    harness.tick()
    harness.tick()
    assert harness.run().state is State.CANCELLED
    assert len(harness.engine.stopped) == 2


def test_progress__is_written_at_intervals(tmp_path: Path) -> None:
    with open_harness(tmp_path, replace(AT_ONCE, progress_interval=3600.0)) as harness:
        attempts = harness.begin(2)
        for step in (1, 2, 3):
            progress: AttemptProgress = {"fraction": step / 10, "seconds": 0.1 * step, "checkpoint": step}
            for attempt in attempts:
                harness.send(ProgressMessage(attempt.key, progress))
            harness.tick()
        rows = [harness.run(number) for number in (0, 1)]
        assert {(row.fraction, row.checkpoint) for row in rows} == {(0.1, 1)}
