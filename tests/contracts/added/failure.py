"""Failure at the first tension beyond a limit."""

from typing import Annotated, NamedTuple

from solver.matter.failure import FailureEntry
from solver.units import Described, Pascal
from solver.vectors import where


class TensionLimit(NamedTuple):
    """The limit of tension."""

    tension: Annotated[Pascal, Described("tension at which matter fails", 1e6, 1e12)]

    def grown_damage(self, damage, loading):
        return where(-loading.pressure >= self.tension, 1.0, damage)


FAILURE = FailureEntry("tension-limit", TensionLimit)
