"""Matter that never fails: only cells that open between particles separate it."""

from typing import NamedTuple

from solver.failure import FailureEntry, grown_damage
from solver.jit import implements


class NoFailure(NamedTuple):
    """Matter is never damaged."""

    order: int = 1  # of nothing: a record wants a field


FAILURE = FailureEntry("none", NoFailure)


@implements(grown_damage, NoFailure)
def _(failure, damage, loading):
    return 0.0  # a constant, so that the compiler leaves out what a failed point does
