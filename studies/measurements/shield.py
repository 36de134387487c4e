"""A shield: the hole of its bumper, the debris between bumper and wall, and whether the wall holds.

Bumper and debris are those of the end of the bumper's stage, by the definitions of a hole (``hole``) and of a debris
cloud (``cloud``). The wall is read as the plate of an impact is: its front is the original surface.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from studies.measurements import Measurement, OnGrid, Reading, measurement
from studies.measurements import cloud as cloud_family
from studies.measurements.cloud import CloudView
from studies.measurements.hole import hole_diameter
from studies.measurements.impact.edges import place_holding
from studies.measurements.impact.view import ImpactView
from studies.measurements.impact.view import view as impact_view
from studies.quantities.measured import STILL_COMING

NOT_REACHED = "not_reached"  # the stage of the bumper has not ended
LATE = 0.01  # of the mass that flies to the wall: while more is to come the wall has not settled
FARTHEST = 1e-3  # of the wall's mass, which stands farther back than its bulge


@dataclass(frozen=True)
class ShieldView(OnGrid):
    """A shield in one of its stages."""

    bumper: ImpactView
    cloud: CloudView
    wall: ImpactView | None  # None in the stage of the bumper
    coming: float  # part of the mass which flies to the wall that has yet to come to its grid
    missed: float  # part of all mass that flew past the wall's grid
    clock_ahead: float  # of the wall's stage, s
    cell: float  # m


def view(setting: Any, snapshot: Any) -> ShieldView:
    """The view of a snapshot (``solver.state.Snapshot``) in a ``ShieldSetting``."""
    here, before, cell = impact_view(setting, snapshot), setting.before, setting.problem.geometry.spacing
    if before is None:
        return ShieldView(here, cloud_family.view(setting, snapshot), None, 1.0, 0.0, 0.0, cell)
    coming = snapshot.waiting / before.coming if before.coming else 0.0
    return ShieldView(before.bumper, before.cloud, here, coming, before.missed, before.clock_ahead, cell)


def _of(part: str, read: Measurement, name: str, title: str, where: str) -> Measurement:
    """A measurement of an impact or a cloud, of a part of the shield."""

    def read_part(view: ShieldView) -> Reading:
        return read.read(getattr(view, part))

    return replace(read, name=name, title=title, meaning=f"{where}: {read.meaning}", read=read_part)


def is_perforated(wall: ImpactView) -> bool:
    """Whether the wall that is connected to its rim has a clear hole, or one that reaches the rim."""
    hole = hole_diameter.read(wall)
    return math.isfinite(hole.value) or "not_contained" in hole.flags


def _wall_hole(view: ShieldView) -> Reading:
    """The clear hole of the wall, as that of a plate."""
    if view.wall is None:
        return Reading(math.nan, flags=(NOT_REACHED,))
    return hole_diameter.read(view.wall)


wall_hole_diameter = replace(
    hole_diameter,
    name="wall_hole_diameter",
    title="Hole of the wall",
    meaning=f"of the rear wall: {hole_diameter.meaning}; not reached while debris flies to it",
    read=_wall_hole,
)


@measurement(
    title="Wall perforated",
    unit="1",
    meaning="1 where the rear wall has a clear hole that can be measured or reaches its rim, else 0; not reached while "
    "debris flies to it",
    version=1,
    is_outcome=True,
)
def wall_perforated(view: ShieldView) -> Reading:
    """Whether the wall that is connected to its rim has a hole."""
    if view.wall is None:
        return Reading(math.nan, flags=(NOT_REACHED,))
    return Reading(float(is_perforated(view.wall)))


@measurement(
    title="Bulge of the wall",
    unit="m",
    meaning="distance behind the wall's original back surface that a thousandth of the mass which is connected to its "
    "rim exceeds; still coming while more than 1 % of the mass that flies to the wall is on its way",
    version=1,
)
def wall_bulge(view: ShieldView) -> Reading:
    """How far back the wall stands, each particle spread over its own width."""
    wall = view.wall
    if wall is None or not wall.attached_target.any():
        return Reading(math.nan, flags=(NOT_REACHED,) if wall is None else ("no_wall",))
    mine = np.flatnonzero(wall.attached_target)
    mass = wall.mass[mine]
    place = place_holding(wall.depth[mine], mass, wall.axial_width, (1.0 - FARTHEST) * float(mass.sum()))
    flags = (STILL_COMING,) if view.coming > LATE else ()
    return Reading(place - wall.thickness, {"resolution": view.resolution}, flags)


_CLOUD = {each.name: each for each in cloud_family.MEASUREMENT}
_BEHIND = "at the end of the bumper's stage"

MEASUREMENT = (
    wall_perforated,
    wall_hole_diameter,
    wall_bulge,
    _of("bumper", hole_diameter, "bumper_hole_diameter", "Hole of the bumper", "of the bumper"),
    *(
        _of("cloud", _CLOUD[name], f"shield_{short}", f"{_CLOUD[name].title}, bumper", _BEHIND)
        for name, short in (
            ("tip_velocity_percent", "tip_velocity"),
            ("rear_velocity", "rear_velocity"),
            ("momentum_behind", "momentum_behind"),
            ("kinetic_energy_behind", "kinetic_energy_behind"),
        )
    ),
)
