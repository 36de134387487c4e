"""A shield: the holes of its bumpers and the debris behind the last of them, each at the end of the bumper's stage.

Their definitions are those of a hole (``hole``) and of debris (``impact/cloud``); those of the wall are in ``wall``.
"""

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from studies.debris.cloud import TOTALS, VELOCITIES, CloudView
from studies.debris.cloud import view as cloud_view
from studies.measurements import Measurement, NoValue, Reading
from studies.measurements.hole import hole_diameter
from studies.measurements.impact.view import ImpactView
from studies.measurements.impact.view import view as impact_view
from studies.quantities.measured import STILL_COMING
from studies.shields.measurements.wall import LATE, NOT_REACHED, WallView, wall_of

if TYPE_CHECKING:
    from solver.state import Snapshot
    from studies.shields.stages import ShieldSetting


@dataclass(frozen=True)
class ShieldView(WallView):
    """A shield in one of its stages; there is no wall in that of a bumper."""

    bumpers: tuple[ImpactView, ...]  # those that debris has come to so far
    cloud: CloudView  # behind the last of them
    missed: float  # part of all mass that flew past the next grid
    clock_ahead: float  # of the stage, s
    attached: float  # momentum of what flies on and has not come off the sheet of the stage, over the projectile's
    angular_momentum_error: float | None = None  # the largest of its flights, relative; None: the planes hold it
    piece: float | None = None  # of the debris that hits the wall: median diameter by mass, m


def view(setting: "ShieldSetting", snapshot: "Snapshot") -> ShieldView:
    """The view of a snapshot."""
    before, bumpers = setting.before, tuple(stage.bumper for stage in setting.before)
    wall, coming, is_half = None, 1.0, setting.problem.geometry.lower[0] < 0.0
    if len(before) < setting.bumpers:
        bumpers, cloud = (*bumpers, impact_view(setting, snapshot)), cloud_view(setting, snapshot)
    else:
        wall, cloud = wall_of(setting, snapshot), before[-1].cloud
    if before:
        coming = snapshot.waiting / before[-1].coming if before[-1].coming else 0.0
    if wall is not None:
        coming = max(coming, _on_its_way(setting, snapshot))
    return ShieldView(
        wall,
        coming,
        any(stage.attached > LATE for stage in before),
        setting.problem.geometry.spacing,
        bumpers,
        cloud,
        missed=sum(stage.missed for stage in before) / sum(stage.mass for stage in before) if before else 0.0,
        clock_ahead=sum(stage.clock_ahead for stage in before),
        attached=_attached(setting, snapshot) if wall is None else 0.0,
        angular_momentum_error=max((stage.angular_momentum_error for stage in before), default=0.0)
        if is_half
        else None,
        piece=before[-1].piece if before else None,
    )


def _on_its_way(setting: "ShieldSetting", snapshot: "Snapshot") -> float:
    """Momentum of the debris on the grid of a wall that has no clear way past it, over the projectile's.

    Debris that has not reached the wall has it, and debris that still drives the wall; what the wall has stopped or
    thrown back has none.
    """
    target = [body.name for body in setting.problem.bodies].index(setting.target)
    return _unclear(setting, snapshot, snapshot.body != target)


def _attached(setting: "ShieldSetting", snapshot: "Snapshot") -> float:
    """Momentum of what flies fast enough to come to the next sheet and has no clear way there, over the projectile's.

    A projectile that goes through has nearly all of its own until it has come off; one that the sheet stops has none.
    """
    from solver.problem.geometry import impact_axis

    velocity = snapshot.particles.velocity[:, impact_axis(setting.problem.geometry)]
    return _unclear(setting, snapshot, velocity > setting.slowest)


def _unclear(setting: "ShieldSetting", snapshot: "Snapshot", among: np.ndarray) -> float:
    """Momentum of particles (n, bool) that no clear way leads off the grid, over the projectile's."""
    from solver.grid.debris import clear_debris
    from solver.problem.geometry import impact_axis

    problem, particles = setting.problem, snapshot.particles
    momentum = particles.mass * particles.velocity[:, impact_axis(problem.geometry)]
    stays = (particles.alive == 1) & among
    stays[clear_debris(problem, particles, snapshot.body, expansion=math.inf)] = False
    return float(momentum[stays].sum()) / setting.momentum


def _hole_of(name: str, where: str, place: int) -> Measurement:
    """The hole of a bumper by its place, from 0 on."""

    def read(view: ShieldView) -> Reading:
        if place >= len(view.bumpers):
            raise NoValue(NOT_REACHED)
        reading = hole_diameter.read(view.bumpers[place])
        is_last = view.wall is None and place == len(view.bumpers) - 1
        is_coming = is_last and (view.attached > LATE or (place > 0 and view.coming > LATE))
        return replace(reading, flags=(*reading.flags, STILL_COMING)) if is_coming else reading

    title, meaning = f"Hole of {where}", f"of {where}: {hole_diameter.meaning}"
    return replace(hole_diameter, name=f"{name}_hole_diameter", title=title, meaning=meaning, definition=read)


def _of_cloud(name: str, short: str) -> Measurement:
    """A measurement of the cloud behind the last bumper."""
    of_cloud = _CLOUD[name]

    def read(view: ShieldView) -> Reading:
        return of_cloud.read(view.cloud)

    title, meaning = f"{of_cloud.title}, bumper", f"at the end of the last bumper's stage: {of_cloud.meaning}"
    return replace(of_cloud, name=f"shield_{short}", title=title, meaning=meaning, definition=read)


_CLOUD = {measured.name: measured for measured in (*TOTALS, *VELOCITIES)}

MEASUREMENT = (
    _hole_of("bumper", "the bumper", 0),
    *(
        _hole_of(f"bumper_{place + 1}", f"the {ordinal} bumper", place)
        for place, ordinal in enumerate(("second", "third", "fourth"), 1)
    ),
    _of_cloud("tip_velocity_percent", "tip_velocity"),
    _of_cloud("rear_velocity", "rear_velocity"),
    _of_cloud("momentum_behind", "momentum_behind"),
    _of_cloud("kinetic_energy_behind", "kinetic_energy_behind"),
)
