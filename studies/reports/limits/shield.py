"""The ballistic limit of a shield at each speed: the simulation's interval of diameters, and what each equation says.

The interval reaches from the largest projectile whose wall holds to the smallest that perforates it. Diameters are
those of the sphere with the projectile's volume, as the equations have them.
"""

import json
import math
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any, Literal

import numpy as np
import xarray as xr

from studies.cubes import reading
from studies.cubes import variables as cubes
from studies.cubes.points import Place, axes_of, by_run, places_of, simulated_values
from studies.cubes.variable import variable_name
from studies.laws import CRITICAL, DRAWN_ONLY, Shot
from studies.observations.shields.drawn import failures_found
from studies.observations.shields.judged import Share
from studies.quantities.findings import InvalidInput
from studies.quantities.measured import doubts_of
from studies.reports.evidence import UNJUDGED_STATES, LawAnswers, answers_of
from studies.sweeps.reading import ACCEPTED
from studies.sweeps.search import interval_of
from studies.sweeps.sweep import Sweep

WALL = "wall_perforated"
DIAMETER = CRITICAL[WALL]
# unsafe: the equation says that the wall holds where the simulation perforates it; careful: the other way round;
# agrees: inside the interval; open: the interval has one end, which does not contradict it; unjudged: the runs at its
# ends are flagged; outside: outside of the equation's range.
EquationWord = Literal["unsafe", "careful", "agrees", "open", "unjudged", "outside"]
MIXED, FLAGGED = "measured by different definitions", "flagged as "


@dataclass(frozen=True)
class WallRun:
    """What the projectile of a point did to the wall."""

    diameter: float  # m
    perforated: bool | None  # None: undecided
    why: str  # it is undecided; else empty
    flags: str  # of its runs, in words


@dataclass(frozen=True)
class CriticalDiameter:
    """What an equation says beside the interval of the simulation."""

    law: str  # label
    title: str
    diameter: float  # m; NaN where it has none
    word: EquationWord
    outside: str  # why it is outside of its range; empty inside

    def excess(self, lower: float, upper: float) -> float:
        """By how much it lies beyond an interval, over the nearer end: below zero where it is smaller."""
        return self.diameter / (upper if self.word == "unsafe" else lower) - 1.0


@dataclass(frozen=True)
class ShieldLimit:
    """Simulation and equations at one speed, on one shield."""

    at: Place  # values of the axes beside speed and diameter
    speed: float  # m/s
    normal_speed: float  # m/s
    runs: tuple[WallRun, ...]  # by ascending diameter
    lower: float  # m: the largest that holds; NaN where none does
    upper: float  # m: the smallest that perforates; NaN where none does
    unjudged: str  # why nothing is judged; else empty
    equations: tuple[CriticalDiameter, ...]
    found: Share | None  # of perforated walls: those that such simulations perforate; None where none was simulated

    @property
    def is_bracketed(self) -> bool:
        """Whether the interval has both ends."""
        return math.isfinite(self.lower) and math.isfinite(self.upper)

    def as_json(self) -> dict[str, Any]:
        """Plain objects: None in place of a number that is none."""
        plain = asdict(self)
        for each in plain["equations"]:
            each["diameter"] = reading.finite(each["diameter"])
        return {**plain, "lower": reading.finite(self.lower), "upper": reading.finite(self.upper)}


def shield_limits(points: xr.Dataset) -> tuple[ShieldLimit, ...]:
    """The limits of a cube of shields, by the other axes and the speed; none where it has no wall, or no equation."""
    if DIAMETER not in reading.critical_of(points) or WALL not in reading.quantities_of(points):
        return ()
    runs, places = _wall_runs(points), places_of(points)
    speed, normal_speeds, found = by_run(points, "speed"), _normal_speeds(points), failures_found_at(points)
    others = [axis for axis in axes_of(points) if axis not in ("speed", "projectile_diameter")]
    groups: dict[tuple[Any, ...], list[int]] = {}
    for cell, place in enumerate(places):
        if math.isfinite(runs[cell].diameter):
            groups.setdefault((*(place[axis] for axis in others), float(speed[cell])), []).append(cell)
    laws = list(answers_of(points, DIAMETER))
    limits = []
    for (*values, at_speed), cells in sorted(groups.items(), key=lambda group: group[0][-1]):
        mine = sorted(cells, key=lambda cell: runs[cell].diameter)
        lower, upper = interval_of({runs[cell].diameter: runs[cell].perforated for cell in mine})
        unjudged = _why_unjudged(points, [runs[cell] for cell in mine if runs[cell].diameter in (lower, upper)])
        limits.append(
            ShieldLimit(
                dict(zip(others, values, strict=True)),
                at_speed,
                normal_speeds[mine[0]],
                tuple(runs[cell] for cell in mine),
                lower,
                upper,
                unjudged,
                tuple(_equations(laws, mine, [runs[cell].diameter for cell in mine], (lower, upper), unjudged)),
                found[mine[0]],
            )
        )
    return tuple(limits)


def failures_found_at(points: xr.Dataset) -> list[Share | None]:
    """Of the perforated walls those that simulations like each point perforate; None where none was simulated so."""
    if "failure" not in points or "speed" not in points:
        return [None] * len(places_of(points))
    speeds = _normal_speeds(points)
    return [failures_found(str(each), v) for each, v in zip(by_run(points, "failure"), speeds, strict=True)]


def _normal_speeds(points: xr.Dataset) -> list[float]:
    speeds = by_run(points, "speed")
    lean = np.cos(by_run(points, "obliquity")) if "obliquity" in points else np.ones(len(speeds))
    return [float(each) for each in speeds * lean]


def shots_of(dataset: xr.Dataset) -> list[tuple[Place, Shot]]:
    """The shots of a sweep with the values of its axes; none of a sweep of another version."""
    with suppress(InvalidInput):
        sweep = Sweep.parse(json.loads(dataset.attrs["sweep"]), ACCEPTED)
        places = ({variable_name(name): value for name, value in at.items()} for at in sweep.coordinates())
        return [(place, shot) for place, shot in zip(places, sweep.shots(), strict=True)]  # type: ignore[misc]
    return []


def shot_at(shots: Sequence[tuple[Place, Shot]], at: Place) -> Shot | None:
    """The first shot at values of axes; None where there is none."""
    return next((shot for place, shot in shots if all(place[name] == value for name, value in at.items())), None)


def _wall_runs(points: xr.Dataset) -> list[WallRun]:
    """What happened at each point; undecided where its grids leave it open, or no run of it has an outcome."""
    outcomes = simulated_values(points, WALL).ravel()
    refined = cubes.VERDICT_REASON.is_in(points, WALL)
    reasons = cubes.VERDICT_REASON.of(points, WALL).values.ravel() if refined else [""] * outcomes.size
    states = cubes.RUN_STATE.of(points).values.ravel()
    diameters, flags = by_run(points, cubes.EQUIVALENT_DIAMETER.name), list(reading.doubts_at(points, WALL))
    runs = []
    for place, (outcome, reason) in enumerate(zip(outcomes, reasons, strict=True)):
        perforated = bool(outcome > 0.5) if math.isfinite(outcome) else None
        why = "" if perforated is not None else str(reason) or UNJUDGED_STATES[cubes.STATES[states[place]]]
        # Several grids have left it open where their finest says so.
        if not refined and perforated is not None and (doubts := doubts_of(outcome, flags[place])):
            perforated, why = None, f"wall {'perforated' if perforated else 'holds'}, but {doubts}"
        runs.append(WallRun(float(diameters[place]), perforated, why, ", ".join(flags[place]).replace("_", " ")))
    return runs


def _why_unjudged(points: xr.Dataset, ends: Sequence[WallRun]) -> str:
    """Why the ends of an interval judge no equation."""
    if reading.mixed_versions(points, WALL):
        return MIXED
    flags = dict.fromkeys(flag for run in ends if run.flags for flag in run.flags.split(", "))
    return FLAGGED + ", ".join(flags) if flags else ""


def why_unjudged(limits: Sequence[ShieldLimit]) -> str:
    """Why the ends of limits judge no equation, each flag once; definitions are mixed at all or at none."""
    flags = dict.fromkeys(flag for limit in limits for flag in limit.unjudged.removeprefix(FLAGGED).split(", ") if flag)
    return MIXED if MIXED in flags else FLAGGED + ", ".join(flags)


def _equations(
    laws: Sequence[LawAnswers],
    cells: Sequence[int],
    diameters: Sequence[float],
    interval: tuple[float, float],
    unjudged: str,
) -> Iterator[CriticalDiameter]:
    """Each equation that enters a verdict, at the points of one speed: its answer where the projectile is nearest."""
    for law in laws:
        values = law.answers[list(cells)]
        if law.confidence in DRAWN_ONLY or not np.isfinite(values).any():
            continue
        nearest = int(np.nanargmin(np.abs(np.log(np.array(diameters) / values))))
        value, outside = float(values[nearest]), law.outside[cells[nearest]]
        word = "outside" if outside else _word(value, *interval, unjudged)
        yield CriticalDiameter(law.label, law.title, value, word, outside)


def _word(diameter: float, lower: float, upper: float, unjudged: str) -> EquationWord:
    if unjudged:
        return "unjudged"
    if diameter > upper:
        return "unsafe"
    if diameter < lower:
        return "careful"
    return "agrees" if math.isfinite(lower) and math.isfinite(upper) else "open"
