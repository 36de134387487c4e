"""States, moves, and the record of a sweep's status."""

import json
from dataclasses import asdict
from datetime import UTC, datetime
from typing import Any

from service.records.jobs import MOVES, TERMINAL, Keep, State, SweepState, SweepStatus, at_least, before
from tests.service.support.rows import lease_of


def test_moves__are_of_every_state_and_end_no_ended_job_otherwise() -> None:
    assert set(MOVES) == frozenset().union(*MOVES.values()) == set(State)
    assert all(not (MOVES[state] & TERMINAL) for state in TERMINAL)
    assert before(State.RUNNING) == {State.QUEUED}
    assert State.RUNNING in before(State.SUCCEEDED)


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
