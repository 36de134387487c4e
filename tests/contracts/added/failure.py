"""Failure at the first tension beyond a limit."""

from typing import Annotated, NamedTuple

from solver.jit import implements
from solver.matter.failure import FailureEntry, grown_damage
from solver.units import Described, Pascal
from solver.vectors import where


class TensionLimit(NamedTuple):
    """The limit of tension."""

    tension: Annotated[Pascal, Described("tension at which matter fails", 1e6, 1e12)]


FAILURE = FailureEntry("tension-limit", TensionLimit)


@implements(grown_damage, TensionLimit)
def grown_damage_of_tension_limit(failure, damage, loading):
    return where(-loading.pressure >= failure.tension, 1.0, damage)
