"""Matter that never fails: only cells that open between particles separate it."""

from typing import NamedTuple

from solver.matter.failure import FailureEntry


class NoFailure(NamedTuple):
    """Matter is never damaged."""

    order: int = 1  # of nothing: a record wants a field

    def grown_damage(self, damage, loading):
        return 0.0  # a constant, so that the compiler leaves out what a failed point does


FAILURE = FailureEntry("none", NoFailure)
