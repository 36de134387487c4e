"""States, moves and budgets."""

from typing import Any

import pytest

from service.records.jobs import (
    BUDGET,
    MOVES,
    TERMINAL,
    Cause,
    Claim,
    Keep,
    Kind,
    State,
    at_least,
    before,
    crashes_before,
    may_try_again,
)


def test_moves__every_state_is_there_and_can_be_left_or_reached() -> None:
    assert set(MOVES) == set(State)
    reached = frozenset().union(*MOVES.values())
    assert reached == set(State)


def test_moves__nothing_that_has_ended_ends_otherwise() -> None:
    assert all(not (MOVES[state] & TERMINAL) for state in TERMINAL)


def test_before__names_the_states_that_a_move_may_start_from() -> None:
    assert before(State.RUNNING) == {State.QUEUED}
    assert State.RUNNING in before(State.SUCCEEDED)


@pytest.mark.parametrize(
    ("cause", "crashes", "again"),
    [
        (Cause.CRASH, 0, True),
        (Cause.CRASH, 1, True),
        (Cause.CRASH, 2, False),
        (Cause.LOST, 99, True),
        (Cause.MEMORY_LIMIT, 0, False),
        (Cause.TIME_LIMIT, 0, False),
        (Cause.ERROR, 0, False),
        (Cause.VERDICT, 0, False),
    ],
)
def test_budget__each_cause_has_its_own(cause: Cause, crashes: int, again: bool) -> None:
    assert may_try_again(cause, crashes) is again


def test_budget__no_cause_is_forgotten() -> None:
    assert set(BUDGET) == set(Cause)


@pytest.mark.parametrize(
    ("crash_step", "step", "counted"),
    [(None, None, 2), (None, 100, 0), (100, 100, 2), (100, 101, 0), (100, 50, 2), (100, None, 2)],
)
def test_crashes__progress_starts_the_count_anew(
    crash_step: int | None, step: int | None, counted: int
) -> None:
    assert crashes_before(claim(crashes=2, crash_step=crash_step), step) == counted


def test_attempt__has_the_same_name_in_every_reign() -> None:
    assert claim(epoch=1).key == claim(epoch=2).key
    assert claim(attempt=1).key != claim(attempt=2).key
    assert claim(token="a").key != claim(token="b").key


def claim(**given: Any) -> Claim:
    plain: dict[str, Any] = {
        "id": "0" * 32,
        "kind": Kind.RUN,
        "attempt": 1,
        "epoch": 1,
        "token": "0" * 8,
        "crashes": 0,
        "crash_step": None,
        "priority": 0,
        "keep": Keep.FINAL,
        "state": State.RUNNING,
        "spec": {},
        "sweep_id": None,
    }
    return Claim(**plain | given)


def test_keep__each_keeps_what_the_lesser_do() -> None:
    assert at_least(Keep.NUMBERS) == set(Keep)
    assert at_least(Keep.FINAL) == {Keep.FINAL, Keep.FILM}
    assert at_least(Keep.FILM) == {Keep.FILM}
