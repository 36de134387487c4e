"""Elastic: no yield surface."""

from typing import NamedTuple

from solver.jit import implements
from solver.matter.strength import StrengthEntry, hardening
from solver.units import Pascal


class Elastic(NamedTuple):
    """Matter that never yields; melting still takes its strength."""

    limit: Pascal = 1e300  # finite, so that zero times it is zero


STRENGTH = StrengthEntry("elastic", Elastic)


@implements(hardening, Elastic)
def hardening_of_elastic(strength, plastic_strain):
    return strength.limit, 0.0
