"""No tensile limit: the thesis' choice; matter parts only where particles lose contact through the grid."""

import math
from typing import NamedTuple

from solver.jit import implements
from solver.matter.tension import TensionEntry, pressure_floor
from solver.units import Pascal


class UnlimitedTension(NamedTuple):
    """Tension without a floor."""

    floor: Pascal = -math.inf


TENSION = TensionEntry("unlimited", UnlimitedTension, molten=True)


@implements(pressure_floor, UnlimitedTension)
def pressure_floor_of_unlimited_tension(tension, homologous):
    return tension.floor
