"""Matter that never fails: only cells that open between particles separate it."""

from typing import NamedTuple

from solver.jit import implements
from solver.matter.failure import FailureEntry, grown_damage


class NoFailure(NamedTuple):
    """Matter is never damaged."""

    order: int = 1  # of nothing: a record wants a field


FAILURE = FailureEntry("none", NoFailure)


@implements(grown_damage, NoFailure)
def grown_damage_of_no_failure(failure, damage, loading):
    return 0.0  # a constant, so that the compiler leaves out what a failed point does
