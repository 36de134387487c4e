"""Sweeps of made-up walls: each is perforated from a known diameter on."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

from studies.cubes import cube
from studies.laws import load
from studies.quantities.measured import Measured
from studies.reports.compare import compare
from studies.reports.section import Part, Source
from studies.runs.results import RunResult
from studies.runs.run import Run
from studies.shields.section import SECTION, BallisticLimit, ShieldLimit
from studies.shields.shield import ShotAtShield
from studies.sweeps.sweep import Sweep

SHIELD = {
    **{"projectile": "al-2017-t4", "bumper": "al-6061-t6", "wall": "al-6061-t6"},
    **{"bumper_thickness": "1 mm", "stand_off": "100 mm", "wall_thickness": "3 mm"},
}
SPEEDS = ["2 km/s", "5 km/s", "7 km/s"]
PLAIN = ["2 mm", "4 mm", "6 mm"]
SHOT = {"speed": "7 km/s", "projectile_diameter": "4 mm"}
# The made-up limit over that of Christiansen's equation, by speed: it is too careful, agrees and is unsafe.
FACTORS = {2e3: 1.25, 5e3: 1.0, 7e3: 0.8}
Limit = Callable[[float], float]


def sweep_of(diameters: Any, **changes: Any) -> Sweep:
    axes = {"speed": SPEEDS, "projectile_diameter": diameters}
    return Sweep.parse({"scenario": "whipple_shield", "fixed": SHIELD, "axes": axes, "resolution": 16, **changes})


@cache
def exact(speed: float) -> float:
    """The made-up limit, m."""
    [shot, *_] = sweep_of(PLAIN).shots()
    return FACTORS[speed] * load("whipple_nno").evaluate(replace(shot, speed=speed)).value


def shots_of(sweep: Sweep) -> list[ShotAtShield]:
    return [shot for shot in sweep.shots() if isinstance(shot, ShotAtShield)]


def result_of(run: Run, limit: Limit = exact, flags: tuple[str, ...] = ()) -> RunResult:
    value = float(float(run.parameters["projectile_diameter"] or 0.0) > limit(float(run.parameters["speed"] or 0.0)))
    measured = {"wall_perforated": Measured(value, None, {}, (), {}, 1)}
    return RunResult(run.id, "succeeded", measurements=measured, flags=flags, stop="settled")


def computed(sweep: Sweep, limit: Limit = exact, flags: tuple[str, ...] = ()) -> dict[str, RunResult]:
    return {point.run.id: result_of(point.run, limit, flags) for point in sweep.runs()}


def part_of(sweep: Sweep, results: Mapping[str, RunResult] | None = None) -> Part:
    """The section of a sweep."""
    dataset = cube.build(sweep, computed(sweep) if results is None else results)
    part = SECTION.part(Source(dataset, compare(dataset), {}))
    assert part is not None
    return part


def record_of(part: Part) -> BallisticLimit:
    assert isinstance(part.record, BallisticLimit)
    return part.record


def rows_of(sweep: Sweep, results: Mapping[str, RunResult] | None = None) -> tuple[ShieldLimit, ...]:
    return record_of(part_of(sweep, results)).rows
