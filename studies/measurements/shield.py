"""A shield: the hole of its bumper and the debris between bumper and wall, at the end of the bumper's stage.

Their definitions are those of a hole (``hole``) and of a debris cloud (``cloud``); those of the wall are in ``wall``.
"""

from dataclasses import dataclass, replace
from typing import Any

from studies.measurements import Measurement, Reading
from studies.measurements import cloud as cloud_family
from studies.measurements.cloud import CloudView
from studies.measurements.hole import hole_diameter
from studies.measurements.impact.view import ImpactView
from studies.measurements.impact.view import view as impact_view
from studies.measurements.wall import WallView, wall_of


@dataclass(frozen=True)
class ShieldView(WallView):
    """A shield in one of its stages; there is no wall in that of the bumper."""

    bumper: ImpactView
    cloud: CloudView
    missed: float  # part of all mass that flew past the wall's grid
    clock_ahead: float  # of the wall's stage, s


def view(setting: Any, snapshot: Any) -> ShieldView:
    """The view of a snapshot (``solver.state.Snapshot``) in a ``ShieldSetting``."""
    before, cell = setting.before, setting.problem.geometry.spacing
    if before is None:
        bumper, cloud = impact_view(setting, snapshot), cloud_family.view(setting, snapshot)
        return ShieldView(None, 1.0, cell, bumper, cloud, missed=0.0, clock_ahead=0.0)
    coming = snapshot.waiting / before.coming if before.coming else 0.0
    wall = wall_of(setting, snapshot)
    return ShieldView(wall, coming, cell, before.bumper, before.cloud, before.missed, before.clock_ahead)


def _of(part: str, read: Measurement, name: str, title: str, where: str) -> Measurement:
    """A measurement of an impact or a cloud, of a part of the shield."""

    def read_part(view: ShieldView) -> Reading:
        return read.read(getattr(view, part))

    return replace(read, name=name, title=title, meaning=f"{where}: {read.meaning}", read=read_part)


_CLOUD = {each.name: each for each in cloud_family.MEASUREMENT}
_BEHIND = "at the end of the bumper's stage"

MEASUREMENT = (
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
