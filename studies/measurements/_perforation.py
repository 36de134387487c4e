"""Whether a plate is perforated, and where: the mass of it on the axis of its hole, and its edges seen along it."""

import numpy as np

from studies.measurements import Reading
from studies.measurements._impact import (
    FILM,
    ImpactView,
    azimuthal_spread,
    contained,
    cumulated,
    equal_area_diameter,
    radii_by_sector,
    rim_flags,
)
from studies.values.results import CLOSED_ON_AXIS


def areal_edges(view: ImpactView) -> np.ndarray:
    """Radius (sectors,) at which the areal density of the connected plate falls to half of its nominal value, m.

    NaN where it never does on the way in from the rim.
    """
    plate = np.flatnonzero(view.attached_target)
    return radii_by_sector(view, plate, view.mass[plate], view.density * view.thickness)


def flag_without_hole(view: ImpactView, edges: np.ndarray) -> str:
    """The reason why a plate with such edges has no hole that can be measured; empty where it has."""
    if np.isnan(edges).any() or is_whole(view):
        return "not_perforated"
    return "" if contained(view, edges) else "not_contained"


def hole_reading(view: ImpactView, radii: np.ndarray, **parts: float) -> Reading:
    """The reading of a hole with the radii (sectors,) of its wall (m); ``parts`` are uncertainties of its own, m."""
    diameter = equal_area_diameter(radii)
    numerical = {"resolution": view.resolution, "azimuth": azimuthal_spread(radii)}
    return Reading(diameter, {**numerical, **parts}, film_flags(view) + rim_flags(view, diameter))


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
