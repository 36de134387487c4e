"""Whether a plate is perforated: what of it still stands on the axis of its hole."""

import numpy as np

from studies.measurements._view import View, cumulated
from studies.results import CLOSED_ON_AXIS

# Particles lose contact when they are drawn more than a cell apart: at a stretch of two, where two fill a cell. A plate
# that is stretched to twice its size in both directions has a quarter of its areal density: what is denser is a plate
# and no numerical film.
FILM = 0.25


def is_whole(seen: View) -> bool:
    """Whether more than a film of the connected plate stands within a cell of the axis.

    Particles are spread over a cell, the width that they have when they are about to lose contact: so the density does
    not jump as a stretched plate takes them across the edge of that cell one by one.
    """
    mine = seen.attached_target
    mass = seen.mass[mine] / seen.sectors
    (found,) = cumulated(seen.radius[mine], mass, seen.cell, np.array([seen.cell]))
    return bool(found > FILM * 0.5 * seen.cell**2 * seen.density * seen.thickness)


def film_flags(seen: View) -> tuple[str, ...]:
    """``closed_on_axis`` where a film of the plate still closes the hole: some stands within a cell of the axis."""
    innermost = np.min(seen.radius[seen.attached_target], initial=np.inf)
    return (CLOSED_ON_AXIS,) if innermost - 0.5 * seen.radial_width < seen.cell else ()
