"""States, moves, budgets, and the record of a sweep's status."""

import json
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

import pytest

from service.records.jobs import (
    BUDGET,
    MOVES,
    TERMINAL,
    Cause,
    Keep,
    State,
    SweepState,
    SweepStatus,
    at_least,
    before,
    crashes_before,
    may_try_again,
)
from tests.service.support.rows import lease_of


def test_moves__are_of_every_state_and_end_no_ended_job_otherwise() -> None:
    assert set(MOVES) == frozenset().union(*MOVES.values()) == set(State)
    assert all(not (MOVES[state] & TERMINAL) for state in TERMINAL)
    assert before(State.RUNNING) == {State.QUEUED}
    assert State.RUNNING in before(State.SUCCEEDED)


@pytest.mark.parametrize(
    ("cause", "crashes", "again"),
    [
        (Cause.CRASH, 1, True),
        (Cause.CRASH, 2, False),
        (Cause.STALLED, 1, True),
        (Cause.STALLED, 2, False),
        (Cause.LOST, 99, True),
        (Cause.MEMORY_LIMIT, 0, False),
        (Cause.TIME_LIMIT, 0, False),
        (Cause.ERROR, 0, False),
        (Cause.VERDICT, 0, False),
    ],
)
def test_budget__is_of_each_cause(cause: Cause, crashes: int, again: bool) -> None:
    assert may_try_again(cause, crashes) is again
    assert set(BUDGET) == set(Cause)


@pytest.mark.parametrize(
    ("crash_step", "step", "counted"),
    [(None, None, 2), (None, 100, 0), (100, 100, 2), (100, 101, 0), (100, 50, 2), (100, None, 2)],
)
def test_crashes__are_counted_anew_after_progress(crash_step: int | None, step: int | None, counted: int) -> None:
    assert crashes_before(lease_of(crashes=2, crash_step=crash_step), step) == counted


def test_attempt__has_one_key_in_every_term() -> None:
    assert lease_of(term=1).key == lease_of(term=2).key
    assert len({lease_of(**{name: 9}).key for name in ("term", "attempt", "token")}) == 3


def test_retention__includes_the_lesser_ones() -> None:
    assert [len(at_least(keep)) for keep in (Keep.NUMBERS, Keep.FINAL, Keep.FILM)] == [3, 2, 1]


def test_status__is_the_same_after_a_journey_as_json() -> None:
    moment = datetime(2026, 11, 22, 12, tzinfo=UTC)
    texts: dict[str, Any] = dict.fromkeys(("id", "name", "title", "scenario", "owner"), "x")
    numbers: dict[str, Any] = {"priority": 1, "planned": 3, "reused": 1, "new": 2}
    status = SweepStatus(
        **texts,
        **numbers,
        keep=Keep.FILM,
        state=SweepState.RUNNING,
        reason=None,
        counts={"queued": 3},
        lost_answers=0,
        progress=0.5,
        eta_seconds=None,
        created=moment,
        cancelled=None,
        finished=moment,
    )
    body = json.loads(json.dumps({**asdict(status), "links": {}}, default=datetime.isoformat))
    assert SweepStatus.from_json(body) == status
    assert not status.is_terminal
