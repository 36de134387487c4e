"""Elastic: no yield surface."""

from typing import NamedTuple

from solver.jit import implements
from solver.strength import StrengthEntry, hardening, rate_and_heat, solid
from solver.units import Pascal


class Elastic(NamedTuple):
    """Matter that never yields; melting still takes its strength."""

    limit: Pascal = 1e300  # finite, so that zero times it is zero


STRENGTH = StrengthEntry("elastic", Elastic)


@implements(hardening, Elastic)
def _(strength, plastic_strain):
    return strength.limit, 0.0


@implements(rate_and_heat, Elastic)
def _(strength, strain_rate, homologous, stiff):
    return solid(homologous)
