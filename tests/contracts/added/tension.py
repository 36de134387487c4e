"""Half of the spall strength, hot or cold."""

from typing import Annotated, NamedTuple

from solver.jit import implements
from solver.matter.tension import TensionEntry, pressure_floor
from solver.units import FromMaterial, Pascal


class HalfTension(NamedTuple):
    """A tensile strength of half the spall strength."""

    spall_strength: Annotated[Pascal, FromMaterial("tension.spall_strength")]


TENSION = TensionEntry("half", HalfTension, molten=True)


@implements(pressure_floor, HalfTension)
def pressure_floor_of_half_tension(tension, homologous):
    return -0.5 * tension.spall_strength
