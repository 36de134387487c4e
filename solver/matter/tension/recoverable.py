"""Recoverable tensile floor: p >= -p_cut (1 - T*), zero when molten.

Nothing is flagged for good: matter that is compressed again carries load again. A permanent flag on the instantaneous
pressure of particles, whose scatter behind a shock is 5 to 30 GPa, would fail most of the material.
"""

from typing import Annotated, NamedTuple

from solver.matter.tension import TensionEntry
from solver.units import FromMaterial, Pascal


class RecoverableTension(NamedTuple):
    """A tensile strength that shrinks with temperature."""

    cutoff: Annotated[Pascal, FromMaterial("tension.spall_strength")]  # p_cut

    def pressure_floor(self, homologous, coherent):
        return -self.cutoff * (1.0 - homologous)


TENSION = TensionEntry("recoverable", RecoverableTension)
