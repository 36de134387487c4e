"""The ballistic limit of a shield at each speed: the interval of the simulation, and what each equation says."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np
import xarray as xr

from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import Place, axes_of, by_run, is_same, places_of, plain, simulated_values
from studies.cubes.variable import variable_name
from studies.laws import DRAWN_ONLY
from studies.outcomes.found import Share
from studies.quantities.findings import InvalidInput
from studies.quantities.measured import doubting_flags
from studies.reports.evidence import LawAnswers, answers_of
from studies.reports.judgement import beginning
from studies.reports.records import Outcome
from studies.shields.section import Equation, Incomparable, ShieldLimit, WallRun
from studies.shields.shield import CRITICAL_DIAMETER, WALL_PERFORATED, ShotAtShield
from studies.shields.shots.answers import SHORT
from studies.shields.shots.chance import probability
from studies.shields.shots.drawn import failures_found
from studies.shields.shots.outside import outside_of_shots
from studies.sweeps.reading import ACCEPTED
from studies.sweeps.search import interval_of
from studies.sweeps.sweep import Sweep

ROUNDED = 1e-6  # relative: of a size, or a speed
TENSION = "recoverable"  # of the drawn shots that were simulated
FAR = 0.1  # probability to fail below which a shot is far from the limit of its shield: the lower risk of safe sizes
LEAST_FOUND = (
    0.5  # share of the published failures that a simulation finds whose "holds" tells something near the limit
)


def has_limits(points: xr.Dataset) -> bool:
    """Whether a cube has a wall, and equations of its limit."""
    return CRITICAL_DIAMETER in reading.critical_of(points) and WALL_PERFORATED in reading.quantities_of(points)


def of_shield(points: xr.Dataset) -> list[str]:
    """The axes beside speed and diameter."""
    return [axis for axis in axes_of(points) if axis not in ("speed", "projectile_diameter")]


def shield_limits(points: xr.Dataset, runs: Sequence[WallRun]) -> tuple[ShieldLimit, ...]:
    """The limits of a cube of shields, by the other axes and the speed, with the run of each of its points."""
    others, places, speeds = of_shield(points), places_of(points), by_run(points, "speed")
    groups: dict[tuple[tuple[float | str, ...], float], list[int]] = {}
    for cell, place in enumerate(places):
        if math.isfinite(runs[cell].diameter):
            groups.setdefault((tuple(place[axis] for axis in others), float(speeds[cell])), []).append(cell)
    laws, normal = list(answers_of(points, CRITICAL_DIAMETER)), normal_speeds(points)
    found = failures_found_at(points) or [None] * len(normal)
    mixed = bool(reading.mixed_versions(points, WALL_PERFORATED))
    limits = []
    for (values, speed), cells in sorted(groups.items(), key=lambda group: group[0][1]):
        mine = sorted(cells, key=lambda cell: runs[cell].diameter)
        lower, upper = interval_of({runs[cell].diameter: runs[cell].perforated for cell in mine})
        ends = [runs[cell] for cell in mine if runs[cell].diameter in (lower, upper)]
        flags = tuple(dict.fromkeys(flag for run in ends for flag in run.flags))
        reason = Incomparable.DEFINITIONS if mixed else Incomparable.FLAGGED if flags else None
        equations = _equations(laws, {cell: runs[cell].diameter for cell in mine}, (lower, upper), reason)
        limits.append(
            ShieldLimit(
                at=dict(zip(others, values, strict=True)),
                speed=speed,
                normal_speed=normal[mine[0]],
                runs=tuple(runs[cell] for cell in mine),
                lower=reading.finite(lower),
                upper=reading.finite(upper),
                reason=reason,
                flags=flags,
                equations=tuple(equations),
                found=found[mine[0]],
            )
        )
    return tuple(limits)


def failures_found_at(points: xr.Dataset) -> list[Share | None] | None:
    """Of the perforated walls those that simulations like each point perforate; None of a cube without failures.

    At a point it is None where no shots were simulated like it.
    """
    if "failure" not in points:
        return None
    speeds = normal_speeds(points)
    tensions = by_run(points, "tension") if "tension" in points else [TENSION] * len(speeds)
    found = zip(by_run(points, "failure"), tensions, speeds, strict=True)
    return [failures_found(str(failure), speed) if tension == TENSION else None for failure, tension, speed in found]


def normal_speeds(points: xr.Dataset) -> list[float]:
    """The component of the velocity along the normal at each point, m/s."""
    speeds = by_run(points, "speed")
    lean = np.cos(by_run(points, "obliquity")) if "obliquity" in points else np.ones(len(speeds))
    return [float(speed) for speed in speeds * lean]


def shots_of(dataset: xr.Dataset) -> list[tuple[Place, ShotAtShield]]:
    """The shots at shields of a sweep with the values of its axes; none of a sweep of another version."""
    with suppress(InvalidInput):
        sweep = Sweep.parse(json.loads(dataset.attrs["sweep"]), ACCEPTED)
        places = ({variable_name(name): plain(value) for name, value in at.items()} for at in sweep.coordinates())
        shots = zip(places, sweep.shots(), strict=True)
        return [(place, shot) for place, shot in shots if isinstance(shot, ShotAtShield)]
    return []


def shots_at(shots: Sequence[tuple[Place, ShotAtShield]], at: Place) -> list[ShotAtShield]:
    """The shots at values of axes."""
    return [shot for place, shot in shots if all(place[name] == value for name, value in at.items())]


def shot_of(
    shots: Sequence[ShotAtShield], speed: float, diameter: float, *, is_sphere: bool = True
) -> ShotAtShield | None:
    """The shot of a run; None where a search tried a cylinder that no shot of the sweep is of."""
    for shot in shots:
        if is_same(shot.speed, speed, ROUNDED) and is_same(shot.projectile_diameter, diameter, ROUNDED):
            return shot
    return replace(shots[0], speed=speed, projectile_diameter=diameter) if shots and is_sphere else None


def with_chances(
    points: xr.Dataset, runs: Sequence[WallRun], shots: Sequence[tuple[Place, ShotAtShield]]
) -> Iterator[WallRun]:
    """The runs of all points with a probability; without it outside of all shots, and where no equation covers one.

    A wall that holds cannot tell near its limit, or where that is unknown, unless simulations like it find failures.
    """
    found = failures_found_at(points) or [None] * len(runs)
    axes = of_shield(points)
    at_shield: dict[tuple[float | str, ...], list[ShotAtShield]] = {}
    for place, shot in shots:
        at_shield.setdefault(tuple(place[axis] for axis in axes), []).append(shot)
    shapes = by_run(points, "projectile_shape")
    for place, speed, shape, run, share in zip(
        places_of(points), by_run(points, "speed"), shapes, runs, found, strict=True
    ):
        mine = at_shield.get(tuple(place[axis] for axis in axes), ())
        told = shot_of(mine, float(speed), run.diameter, is_sphere=str(shape) == "sphere")
        if told is None or math.isnan(run.diameter):  # a point of a search that has no run
            yield run
            continue
        chance = probability(told)
        outside = "" if chance else next(outside_of_shots(told), "")
        is_near = chance is None or chance.value >= FAR
        misses = share is None or not share.value >= LEAST_FOUND
        cannot_tell = run.perforated is False and is_near and misses
        yield replace(run, probability=chance, outside=outside, cannot_tell=cannot_tell)


def wall_runs(points: xr.Dataset) -> list[WallRun]:
    """What happened at each point; undecided where its grids leave it open, or no run of it has an outcome."""
    outcomes = simulated_values(points, WALL_PERFORATED).ravel()
    refined = cubes.VERDICT_REASON.is_in(points, WALL_PERFORATED)
    grids = cubes.VERDICT_REASON.of(points, WALL_PERFORATED).values.ravel() if refined else [""] * outcomes.size
    states = cubes.RUN_STATE.of(points).values.ravel()
    diameters, flags = by_run(points, cubes.EQUIVALENT_DIAMETER.name), list(reading.doubts_at(points, WALL_PERFORATED))
    runs = []
    for place, outcome in enumerate(outcomes):
        says = bool(outcome > 0.5) if math.isfinite(outcome) else None
        # Several grids have left it open where their finest says so.
        doubts = doubting_flags(outcome, flags[place]) if says is not None and not refined else ()
        runs.append(
            WallRun(
                diameter=float(diameters[place]),
                perforated=None if doubts else says,
                says=says,
                state=cubes.STATES[states[place]],
                grids=str(grids[place]),
                flags=tuple(flags[place]),
                doubts=doubts,
            )
        )
    return runs


def _equations(
    laws: Sequence[LawAnswers], runs: Mapping[int, float], interval: tuple[float, float], reason: Incomparable | None
) -> list[Equation]:
    """Each equation that may judge, at the diameters of cells of one speed: nearest first, outside its range last."""
    found = []
    cells, diameters = list(runs), np.array(list(runs.values()))
    for law in laws:
        values = law.answers[cells]
        if law.confidence in DRAWN_ONLY or not np.isfinite(values).any():
            continue
        nearest = int(np.nanargmin(np.abs(np.log(diameters / values))))  # the projectile nearest to what it says
        diameter, outside = float(values[nearest]), law.outside[cells[nearest]]
        why = Incomparable.OUTSIDE if outside else reason
        outcome, difference, why = (Outcome.NOT_COMPARABLE, None, why) if why else _beside(diameter, *interval)
        name = name_of(law.label, law.title)
        found.append(Equation(law.label, law.title, name, diameter, outcome, difference, why, outside))
    ends = [end for end in interval if math.isfinite(end)] or list(diameters)
    middle = float(np.log(ends).mean())
    return sorted(found, key=lambda said: (bool(said.outside), abs(math.log(said.diameter) - middle)))


def _beside(diameter: float, lower: float, upper: float) -> tuple[Outcome, float | None, Incomparable | None]:
    """A critical diameter beside an interval, whose ends are NaN where there are none."""
    if diameter > upper:
        return Outcome.HIGH, diameter / upper - 1.0, None
    if diameter < lower:
        return Outcome.LOW, diameter / lower - 1.0, None
    ends = math.isfinite(lower) + math.isfinite(upper)
    if ends == 2:
        return Outcome.WITHIN, 0.0, None
    return Outcome.NOT_COMPARABLE, None, Incomparable.ONE_END if ends else Incomparable.NO_END


def name_of(label: str, title: str) -> str:
    """The author with what the field calls the equation: "Christiansen (NNO)", "Reimerdes"."""
    author, short = beginning(title), SHORT.get(label.partition("/")[0], "")
    return f"{author} ({short})" if short not in ("", author, title) else author
