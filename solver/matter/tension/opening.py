"""Matter that opens: tension ends where its voids have linked, and until they have closed again.

Up to there matter bears p >= -p_cut k, with the part k of its cold strength that melting leaves
(``melting.coherence``), or what its failure lets it bear. Once its volume has grown by the voids that link it has
parted: it bears neither tension nor shear until it is so dense again that it has a pressure, and then it is whole.
Without that a continuum at a third of its density is stretched against its tension until it melts, which no metal
does: at 1.2 GPa that takes 0.8 MJ/kg in aluminium, more than from room temperature to its melting point.

Flow opens matter too: voids in plastic matter grow by ln(f / f_0) = 3 x 0.283 exp(1.5 T) d eps with the triaxiality T
(Rice and Tracey (1969), J. Mech. Phys. Solids 17, 201), so that a sheet which is stretched to several times its width
parts though its volume does not grow. Beyond the triaxialities of notched bars spall decides.

The void fraction is that beside matter which has no pressure with the same energy: heat alone opens nothing.
"""

import math
from typing import Annotated, NamedTuple

from solver.matter.tension import TensionEntry
from solver.units import FromMaterial, Pascal
from solver.vectors import exp, minimum, where

# Void fraction at which voids link. Grady (1988), J. Mech. Phys. Solids 36, 353: 0.15 is the strain that ends ductile
# spall, "typical for aluminium" in the manual of Ansys Explicit Dynamics. Voids in copper link once the ligament is as
# long as their radius (Seppala, Belak and Rudd (2004), Phys. Rev. Lett. 93, 245503): 0.155 on a cubic lattice.
LINKING = 0.15

# Void fraction from which on flow makes voids grow, 3 Y / (2 e E) of aluminium alloys: that of a hollow sphere which
# yields at the tension of a void alone (``failure/void_growth.py``).
DILUTE = 2e-3
RICE_TRACEY = 3.0 * 0.283
# Of notched bars: Johnson and Cook (1985), Eng. Fract. Mech. 21, 31, measured up to about 1.
NOTCHED = 1.0


class OpeningTension(NamedTuple):
    """A tensile strength that melting takes, of matter that parts."""

    cutoff: Annotated[Pascal, FromMaterial("tension.spall_strength")]  # p_cut

    def pressure_floor(self, homologous, coherent):
        return -self.cutoff * coherent

    def linking(self):
        return LINKING

    def void_growth(self, loading):
        notched = minimum(loading.triaxiality, NOTCHED)
        growth = RICE_TRACEY * exp(1.5 * notched) * loading.slip
        return where(loading.pressure < 0.0, growth, 0.0)

    def opens_by_flow(self, grown):
        return grown > math.log(LINKING / DILUTE)


TENSION = TensionEntry("opening", OpeningTension, opens=True)
