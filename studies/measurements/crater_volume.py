"""The volume of a crater below the original surface."""

import math

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._crater import deepest_floor, wall
from studies.measurements._impact import ImpactView, contained


def _read(view: ImpactView) -> Reading:
    """The areas inside the wall of layers a cell high, from the original surface to the floor.

    The layers of an oblique crater are about a line from the middle of its mouth to its deepest place. What the
    volume's surface may be off by stands in its uncertainty: a cell all over the floor and wall, a hemisphere's.
    """
    floor = deepest_floor(view)
    if not floor.depth >= view.cell:
        return Reading(math.nan, flags=("no_crater",))
    if floor.depth >= view.thickness - view.cell:
        return Reading(math.nan, flags=("perforated",))
    layers = math.ceil(floor.depth / view.cell)
    height = floor.depth / layers
    middles = height * (np.arange(layers) + 0.5)
    radii = np.array([wall(view, float(z), height, place=z / floor.depth * floor.place) for z in middles])
    if np.isnan(radii[0]).any():
        return Reading(math.nan, flags=("no_crater",))
    radii = np.nan_to_num(radii)
    if not contained(view, radii):
        return Reading(math.nan, flags=("not_contained",))
    areas = math.pi * np.mean(radii**2, axis=1)
    surface = 2.0 * math.pi * float(np.mean(radii[0] ** 2))
    return Reading(float(height * areas.sum()), {"resolution": surface * view.resolution})


MEASUREMENT = Measurement(
    name="crater_volume",
    title="Crater volume",
    unit="m3",
    meaning="volume between the original surface and the floor of a crater, of the whole crater also from a sector: "
    "the area inside the wall in layers a cell high, where the wall of a sector is the radius at which matter "
    "connected to the target, by its undisturbed volume, first fills half of a window of two cells, halved by area, on "
    "the way out",
    version=3,
    read=_read,
)
