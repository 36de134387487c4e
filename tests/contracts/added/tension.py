"""Half of the spall strength, hot or cold."""

from typing import Annotated, NamedTuple

from solver.matter.tension import TensionEntry
from solver.units import FromMaterial, Pascal


class HalfTension(NamedTuple):
    """A tensile strength of half the spall strength."""

    spall_strength: Annotated[Pascal, FromMaterial("tension.spall_strength")]

    def pressure_floor(self, homologous, coherent):
        return -0.5 * self.spall_strength


TENSION = TensionEntry("half", HalfTension, molten=True)
