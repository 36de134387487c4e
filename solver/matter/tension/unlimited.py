"""No tensile limit: the thesis' choice; matter parts only where particles lose contact through the grid."""

import math
from typing import NamedTuple

from solver.matter.tension import TensionEntry
from solver.units import Pascal


class UnlimitedTension(NamedTuple):
    """Tension without a floor."""

    floor: Pascal = -math.inf

    def pressure_floor(self, homologous, coherent):
        return self.floor


TENSION = TensionEntry("unlimited", UnlimitedTension, molten=True)
