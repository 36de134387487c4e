"""Elastic, perfectly plastic: a constant yield stress until melting."""

from typing import Annotated, NamedTuple

from solver.jit import implements
from solver.matter.strength import StrengthEntry, hardening
from solver.units import Described, Pascal


class PerfectlyPlastic(NamedTuple):
    """Parameters of perfect plasticity."""

    yield_stress: Annotated[Pascal, Described("yield stress", 0.0, 1e12, usual=(1e6, 5e9))]


STRENGTH = StrengthEntry("perfectly-plastic", PerfectlyPlastic)


@implements(hardening, PerfectlyPlastic)
def hardening_of_perfectly_plastic(strength, plastic_strain):
    return strength.yield_stress, 0.0
