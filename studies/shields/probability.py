"""The probability that a simulated wall fails: from equations and shots, and joined with what the simulation says."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
import xarray as xr

from studies.cubes.points import Place, by_run, is_same, places_of, plain, refinements_of
from studies.cubes.variables import EQUIVALENT_DIAMETER
from studies.quantities.numerical_defaults import RECIPES
from studies.shields.section import Apart, NotJoined, ShieldLimit, WallChance, WallRun
from studies.shields.shield import ShotAtShield
from studies.shields.shots.chance import Probability, probability
from studies.shields.shots.drawn import SimulationKind
from studies.shields.shots.joined import Joint, Simulated, cells_across, cells_through, joint
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


def with_chances(
    dataset: xr.Dataset, points: xr.Dataset, limits: Sequence[ShieldLimit], shots: Sequence[tuple[Place, ShotAtShield]]
) -> tuple[ShieldLimit, ...]:
    """Limits whose runs have a probability; none outside of all shots, and where no equation covers a run."""
    axes, has_grids = [*limits[0].at], CELLS[0] in refinements_of(dataset)
    columns = {name: by_run(points, name) for name in ("failure", *CALIBRATED, *CELLS) if name in points.variables}
    if CELLS[0] not in columns:  # of several grids the finest
        columns[CELLS[0]] = np.full(points.run_state.size, dataset[CELLS[0]].max())
    sizes = zip(by_run(points, "speed"), by_run(points, EQUIVALENT_DIAMETER.name), strict=True)
    cells = {
        (*(place[axis] for axis in axes), *map(float, size)): cell
        for cell, (place, size) in enumerate(zip(places_of(points), sizes, strict=True))
    }

    of_shield: dict[tuple[float | str, ...], list[ShotAtShield]] = {}
    for place, shot in shots:
        of_shield.setdefault(tuple(place[axis] for axis in axes), []).append(shot)

    def chanced(limit: ShieldLimit, run: WallRun) -> WallRun:
        cell = cells[*limit.at.values(), limit.speed, run.diameter]
        settings = {name: plain(column[cell]) for name, column in columns.items()}
        is_sphere, mine = settings["projectile_shape"] == "sphere", of_shield.get(tuple(limit.at.values()), ())
        shot = shot_of(mine, limit.speed, run.diameter, is_sphere=is_sphere)
        return _with_chance(run, shot, settings, has_grids) if shot else run

    return tuple(replace(limit, runs=tuple(chanced(limit, run) for run in limit.runs)) for limit in limits)


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
    constants = joint(kind)
    apart = _apart(constants, shot, settings)
    joined = constants.probability(before, TOLD[run.perforated]) if constants and not apart else None
    return replace(run, before=_chance(before), joined=_chance(joined) if joined else None, apart=apart)


def _chance(probability: Probability) -> WallChance:
    return WallChance(probability.value, probability.low, probability.high)


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
