"""States, moves and budgets."""

import pytest

from service.jobs import BUDGET, MOVES, TERMINAL, Cause, State, before, may_try_again


def test_moves__every_state_is_there_and_can_be_left_or_reached() -> None:
    assert set(MOVES) == set(State)
    reached = frozenset().union(*MOVES.values())
    assert reached == set(State)


def test_moves__a_result_is_never_queued_again_by_itself() -> None:
    assert State.QUEUED not in MOVES[State.SUCCEEDED]
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
        (Cause.TIME_LIMIT, 0, False),
        (Cause.ERROR, 0, False),
        (Cause.VERDICT, 0, False),
    ],
)
def test_budget__each_cause_has_its_own(cause: Cause, crashes: int, again: bool) -> None:
    assert may_try_again(cause, crashes) is again


def test_budget__no_cause_is_forgotten() -> None:
    assert set(BUDGET) == set(Cause)
