"""Elastic, perfectly plastic: a constant yield stress until melting."""

from typing import Annotated, NamedTuple

from solver.matter.strength import StrengthEntry
from solver.units import Described, Pascal


class PerfectlyPlastic(NamedTuple):
    """Parameters of perfect plasticity."""

    yield_stress: Annotated[Pascal, Described("yield stress", 0.0, 1e12, usual=(1e6, 5e9))]

    def hardening(self, plastic_strain):
        return self.yield_stress, 0.0


STRENGTH = StrengthEntry("perfectly-plastic", PerfectlyPlastic)
