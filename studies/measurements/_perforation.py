"""Whether a plate is perforated: the mass of it that still stands on the axis of its hole."""

import numpy as np

from studies.measurements._impact import ImpactView, cumulated
from studies.results import CLOSED_ON_AXIS

# Particles lose contact when they are drawn more than a cell apart: at a stretch of two, where two fill a cell. A plate
# that is stretched to twice its size in both directions has a quarter of its areal density: what is denser is a plate
# and no numerical film.
FILM = 0.25


def is_whole(view: ImpactView) -> bool:
    """Whether more than a film of the connected plate stands within a cell of the axis.

    Particles are spread over a cell, the width that they have when they are about to lose contact: so the density does
    not jump as a stretched plate takes them across the edge of that cell one by one.
    """
    mine = view.attached_target
    mass = view.mass[mine] / view.sectors
    (standing,) = cumulated(view.radius[mine], mass, view.cell, np.array([view.cell]))
    return bool(standing > FILM * 0.5 * view.cell**2 * view.density * view.thickness)


def film_flags(view: ImpactView) -> tuple[str, ...]:
    """``closed_on_axis`` where a film of the plate still closes the hole: some stands within a cell of the axis."""
    innermost = np.min(view.radius[view.attached_target], initial=np.inf)
    return (CLOSED_ON_AXIS,) if innermost - 0.5 * view.radial_width < view.cell else ()
