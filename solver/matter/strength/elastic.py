"""Elastic: no yield surface."""

from typing import NamedTuple

from solver.matter.strength import StrengthEntry
from solver.units import Pascal


class Elastic(NamedTuple):
    """Matter that never yields; melting still takes its strength."""

    limit: Pascal = 1e300  # finite, so that zero times it is zero

    def hardening(self, plastic_strain):
        return self.limit, 0.0


STRENGTH = StrengthEntry("elastic", Elastic)
