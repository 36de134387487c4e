"""The hole of a projectile at the front and at the rear face of a plate."""

import math
from collections.abc import Callable

import numpy as np

from studies.measurements import Measurement, Reading
from studies.measurements._impact import edge_from_outside
from studies.measurements._plug import PlugView

START = 2.0  # projectile diameters from the axis, from where on the edge is looked for inwards


def _at(face: Callable[[PlugView], np.ndarray]) -> Callable[[PlugView], Reading]:
    """The reading of the hole in the layer of a face, from the distance (n,) of particles to it at the start."""

    def read(view: PlugView) -> Reading:
        if not view.is_open():
            return Reading(math.nan, flags=("not_perforated",))
        mine = view.attached & (face(view) < view.layer)
        areal = 2.0 * math.pi * view.density * view.layer
        edge = edge_from_outside(
            view.radius[mine],
            view.mass[mine],
            width=view.width,
            window=view.cell,
            start=min(START * view.projectile_diameter, min(view.plate_radius, view.particles_to) - view.cell),
            stop=0.0,
            nominal=lambda low, high: 0.5 * areal * (high**2 - low**2),
        )
        return Reading(2.0 * edge, {"resolution": view.resolution})

    return read


def _hole(name: str, side: str, face: Callable[[PlugView], np.ndarray]) -> Measurement:
    return Measurement(
        name=f"hole_diameter_{name}",
        title=f"Hole diameter, {side} face",
        unit="m",
        meaning=f"diameter at which the areal density of the layer at the {side} face, a tenth of the thickness or a "
        "cell, falls to half of its nominal value on the way in; of the plate that has not failed and hangs together "
        "with the rim",
        version=1,
        read=_at(face),
    )


MEASUREMENT = (
    _hole("front", "front", lambda view: view.origin),
    _hole("rear", "rear", lambda view: view.thickness - view.origin),
)
