"""The probability that a simulated wall fails: from equations and shots, and joined with what the simulation says."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import count

import numpy as np
import xarray as xr

from studies.cubes.points import Place, by_run, is_same, places_of, plain, refinements_of
from studies.quantities.numerical_defaults import RECIPES
from studies.shields.limit import of_shield
from studies.shields.section import Apart, NotJoined, WallRun
from studies.shields.shield import ShotAtShield
from studies.shields.shots.chance import probability
from studies.shields.shots.drawn import Joint, Simulated, SimulationKind, stored
from studies.shields.shots.joined import cells_across, cells_through
from studies.shields.shots.outside import outside_of_shots

ROUNDED = 1e-6  # relative: of a number of cells, or a size
# How the simulated shots were computed: by one recipe, and all cells by the rule.
_RECIPE = RECIPES["whipple"]
CALIBRATED: Mapping[str, float | str] = {
    **{"geometry": "axisymmetric", "projectile_shape": "sphere", "edges": "fixed", "eos_form": "hugoniot"},
    **{"contact": "none", "particles_per_cell": _RECIPE.particles_per_cell},
    **{"shape": _RECIPE.shape, "scheme": _RECIPE.scheme, "tension": _RECIPE.tension},
    **{"viscosity_linear": _RECIPE.viscosity_linear, "viscosity_quadratic": _RECIPE.viscosity_quadratic},
}
CELLS = ("cells_per_diameter", "cells_per_wall")
TOLD: dict[bool | None, Simulated] = {True: "perforated", False: "held", None: "open"}

RunSettings = Mapping[str, float | str]
Shield = tuple[float | str, ...]  # by the values of the axes that tell it


def with_chances(
    dataset: xr.Dataset, points: xr.Dataset, runs: Sequence[WallRun], shots: Sequence[tuple[Place, ShotAtShield]]
) -> list[WallRun]:
    """The runs of all points with a probability; without it outside of all shots, and where no equation covers one."""
    axes, has_grids = of_shield(points), CELLS[0] in refinements_of(dataset)
    columns = {name: by_run(points, name) for name in ("failure", *CALIBRATED, *CELLS) if name in points.variables}
    if CELLS[0] not in columns:  # of several grids the finest
        columns[CELLS[0]] = np.full(points.run_state.size, dataset[CELLS[0]].max())
    at_shield: dict[Shield, list[ShotAtShield]] = {}
    for place, shot in shots:
        at_shield.setdefault(tuple(place[axis] for axis in axes), []).append(shot)

    def chanced(cell: int, place: Place, speed: float, run: WallRun) -> WallRun:
        if math.isnan(run.diameter):  # a point of a search that has no run
            return run
        settings = {name: plain(column[cell]) for name, column in columns.items()}
        mine = at_shield.get(tuple(place[axis] for axis in axes), ())
        shot = shot_of(mine, speed, run.diameter, is_sphere=settings["projectile_shape"] == "sphere")
        return _with_chance(run, shot, settings, has_grids) if shot else run

    speeds = map(float, by_run(points, "speed"))
    return list(map(chanced, count(), places_of(points), speeds, runs))


def shot_of(
    shots: Sequence[ShotAtShield], speed: float, diameter: float, *, is_sphere: bool = True
) -> ShotAtShield | None:
    """The shot of a run; None where a search tried a cylinder that no shot of the sweep is of."""
    for shot in shots:
        if is_same(shot.speed, speed, ROUNDED) and is_same(shot.projectile_diameter, diameter, ROUNDED):
            return shot
    return replace(shots[0], speed=speed, projectile_diameter=diameter) if shots and is_sphere else None


def _with_chance(run: WallRun, shot: ShotAtShield, settings: RunSettings, has_grids: bool) -> WallRun:
    before = probability(shot)
    if before is None:
        return replace(run, outside=next(outside_of_shots(shot), ""))
    kind = SimulationKind((str(settings["failure"]),), "several" if has_grids else "one")
    constants = stored().get(kind.name)
    apart = _apart(constants, shot, settings)
    joined = constants.probability(before, TOLD[run.perforated]) if constants and not apart else None
    return replace(run, before=before, joined=joined, apart=apart)


def _apart(constants: Joint | None, shot: ShotAtShield, settings: RunSettings) -> NotJoined | None:
    """Why no simulated shots are like a run, or why they say nothing."""
    if constants is None:
        return NotJoined(Apart.NO_SUCH_SHOTS, "failure", settings["failure"])
    if not constants.is_joined_at(shot.normal_speed):
        return NotJoined(Apart.NO_GAIN, "failure", settings["failure"])
    if shot.obliquity:
        return NotJoined(Apart.ANGLE)
    for name, calibrated in CALIBRATED.items():
        if settings[name] != calibrated:
            return NotJoined(Apart.SETTING, name, settings[name])
    across = cells_across(shot.projectile_diameter, shot.shield.bumper_thickness)
    through = cells_through(shot.shield.wall_thickness, shot.projectile_diameter, across)
    for name, least, reason in zip(CELLS, (across, through), (Apart.CELLS_ACROSS, Apart.CELLS_THROUGH), strict=True):
        if float(settings[name]) < least * (1.0 - ROUNDED):
            return NotJoined(reason, name, least)
    return None
