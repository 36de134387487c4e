"""Invented sweeps, runs and laws: smooth numbers, so that cube and report are tested alone."""

import hashlib
import itertools
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from studies.cubes.catalogue import Catalogue, Observed
from studies.cubes.cells import MissingResult
from studies.cubes.variable import Quantity
from studies.laws import NO_RANGE, LawValue
from studies.sweeps.axes import Axis
from studies.values.parameters import Parameter
from studies.values.results import DEFINITION, Measured, RunResult

DIAMETER = 0.008
CELLS = (16.0, 32.0, 64.0)
OFFSETS = (0.0, 0.333333333333, 0.666666666667)
SPEEDS = (2000.0, 3000.0, 4000.0, 5000.0, 6000.0, 7000.0)
THICKNESSES = (0.002, 0.003, 0.004)
SOUND_SPEED = 3940.0
VERDICTS = {  # of refinement, by speed: see mesh_error
    2e3: "converging",
    3e3: "converging",
    4e3: "oscillatory",
    5e3: "not in the asymptotic range",
    6e3: "not in the asymptotic range",
    7e3: "converging",
}


@dataclass(frozen=True)
class Run:
    parameters: Mapping[str, Any]
    scenario: str = "thin_plate"
    materials: Mapping[str, Any] = field(default_factory=lambda: {"target": {"family": "copper"}})

    @property
    def id(self) -> str:
        text = json.dumps([self.scenario, dict(self.parameters)], sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()[:32]


@dataclass(frozen=True)
class Point:
    index: tuple[int, ...]
    coordinates: Mapping[str, Any]
    run: Run


@dataclass(frozen=True)
class Sweep:
    axes: tuple[Axis, ...]
    fixed: Mapping[str, Any] = field(
        default_factory=lambda: {"projectile_diameter": DIAMETER, "projectile": "copper-ofhc"}
    )
    combine: str = "grid"
    scenario: str = "thin_plate"
    title: str = "Holes in copper plates"
    refinements: tuple[Axis, ...] = ()
    model_part: str = "stored"
    searched: None = None

    @property
    def shape(self) -> tuple[int, ...]:
        lengths = tuple(len(axis.values) for axis in self.axes)
        points = lengths if self.combine == "grid" else lengths[:1]
        return points + tuple(len(axis.values) for axis in self.refinements)

    def document(self) -> dict[str, Any]:
        axes = {axis.name: list(axis.values) for axis in self.axes}
        return {
            "title": self.title,
            "scenario": self.scenario,
            "fixed": {name: f"{1000 * v:g} mm" if isinstance(v, float) else v for name, v in self.fixed.items()},
            "axes": axes,
            "combine": self.combine,
            "resolution": next((list(a.values) for a in self.refinements if "cells" in a.name), 32.0),
        }

    def runs(self) -> list[Point]:
        places = [range(len(axis.values)) for axis in self.axes]
        rows = itertools.product(*places) if self.combine == "grid" else zip(*places, strict=True)
        steps = list(itertools.product(*(range(len(axis.values)) for axis in self.refinements)))
        return [self._point(number, index, step) for number, index in enumerate(rows) for step in steps]

    def _point(self, number: int, index: Sequence[int], step: tuple[int, ...]) -> Point:
        axes = (*self.axes, *self.refinements)
        places = (*index, *step)
        at = {axis.name: axis.values[place] for axis, place in zip(axes, places, strict=True)}
        place = tuple(index) if self.combine == "grid" else (number,)
        return Point(place + step, at, Run({**self.fixed, **at}, self.scenario))


@dataclass(frozen=True)
class Shot:
    speed: float
    projectile_diameter: float
    plate_thickness: float | None


@dataclass(frozen=True)
class Range:
    words: str


@dataclass(frozen=True)
class Law:
    """A law of tests: a formula of speed and thickness, good above one speed and below another."""

    name: str
    quantity: str
    formula: Any  # (shot, variant) -> D/d
    labels: tuple[str, ...] = ("",)
    valid: tuple[float, float] = (0.0, 1e9)
    title: str = "a law of the tests"
    equation: str = "D/d = f(v, t/d)"
    source: str = "Nobody (1999), Eq. 1"
    confidence: str = "read"
    scatter: float | None = None
    rangeless: bool = False  # whether its source states no range

    @property
    def range(self) -> Range:
        low, high = (bound / 1000 for bound in self.valid)
        return Range(f"{NO_RANGE}: " * self.rangeless + f"{low:g} to {high:g} km/s")

    def variants(self, shot: Shot) -> tuple[str, ...]:
        return self.labels

    def is_fitted_to(self, shot: Shot, value: float) -> bool:
        return False

    def evaluate(self, shot: Shot, variant: str) -> LawValue:
        value = self.formula(shot, variant) * shot.projectile_diameter
        inside = self.valid[0] <= shot.speed <= self.valid[1]
        if math.isnan(value):
            return LawValue(value, False, "below its physical limit")
        return LawValue(value, inside, "" if inside else f"speed outside {self.range.words}")


def _maiden(shot: Shot, variant: str) -> float:
    ratio = (shot.plate_thickness or 0.0) / shot.projectile_diameter
    return 0.45 * shot.speed / 1000 * ratio ** (2 / 3) + 0.90


def _maiden_c(shot: Shot, variant: str) -> float:
    ratio = (shot.plate_thickness or 0.0) / shot.projectile_diameter
    return 2.40 * shot.speed / SOUND_SPEED * ratio ** (2 / 3) + 0.90


def _zhang(shot: Shot, variant: str) -> float:
    ratio = (shot.plate_thickness or 0.0) / shot.projectile_diameter
    value = 1.66 * math.sqrt((shot.speed / 1000 - 1) * ratio)
    return value if value >= 1 else math.nan


def _strength(shot: Shot, variant: str) -> float:
    stress = float(variant.split()[2]) * 1e6
    return 1.68 * math.log(shot.speed / math.sqrt(stress / 8930)) - 1.91


YIELDS = ("Y = 240 MPa", "Y = 157 MPa", "Y = 120 MPa", "Y = 90 MPa")
HOLE_LAWS = (
    Law("maiden_al", "hole_diameter", _maiden, valid=(2500.0, 5500.0), title="thesis 1-3, aluminium"),
    Law("maiden_c", "hole_diameter", _maiden_c, title="general form with the sound speed"),
    Law("zhang_tan", "hole_diameter", _zhang, title="thesis 1-4"),
    Law("strength_ln", "hole_diameter", _strength, labels=YIELDS, valid=(0.0, 1.0), title="thesis 1-5"),
)
CRATER_LAWS = (
    Law("charters_summers", "crater_depth", lambda s, _: 2.28 * (s.speed / 3940) ** (2 / 3)),
    Law("two_thirds", "crater_depth", lambda s, _: 0.431 * 8.93 ** (1 / 3) * (s.speed / 1e3) ** (2 / 3)),
)
PARAMETERS = {
    name: Parameter(name=name, kind=kind, unit=unit, meaning=meaning)  # type: ignore[arg-type]
    for name, kind, unit, meaning in (
        ("speed", "quantity", "m s-1", "speed of impact"),
        ("plate_thickness", "quantity", "m", "thickness of the plate"),
        ("projectile_diameter", "quantity", "m", "diameter of the projectile"),
        ("projectile", "material", None, "material of the projectile"),
        ("cells_per_diameter", "quantity", "1", "cells across the projectile"),
        ("offset", "quantity", "1", "position of the grid, in cells"),
        ("target.strength.A", "quantity", "Pa", "initial yield stress"),
        ("method", "choice", None, "method that computes"),
    )
}
HOLES = {
    "hole_diameter": Quantity("hole_diameter", "m", "clear opening"),
    "hole_diameter_areal": Quantity("hole_diameter_areal", "m", "opening by areal density"),
}
CRATERS = {
    "crater_depth": Quantity("crater_depth", "m", "depth from the original surface"),
    "crater_diameter": Quantity("crater_diameter", "m", "diameter at the original surface"),
    "crater_depth_over_diameter": Quantity("crater_depth_over_diameter", "1", "depth over diameter"),
}
MATERIALS = {
    "copper-ofhc": {
        "title": "OFHC copper",
        "numbers": {
            "density": {"value": 8930.0, "unit": "kg m-3", "source": "Marsh (1980)", "confidence": "read"},
            "strength.A": {"value": 90e6, "unit": "Pa", "source": "Johnson & Cook (1983)", "confidence": "read"},
        },
    }
}


def shot_of(run: Run) -> Shot:
    p = run.parameters
    return Shot(p.get("speed", 5000.0), p["projectile_diameter"], p.get("plate_thickness"))


def catalogue(scenario: str = "thin_plate", observations: Sequence[Observed] = ()) -> Catalogue:
    holes = scenario == "thin_plate"
    return Catalogue(
        title="Perforation of a thin plate" if holes else "Crater in a thick plate",
        parameters=PARAMETERS,
        quantities=HOLES if holes else CRATERS,
        laws=HOLE_LAWS if holes else CRATER_LAWS,
        shot_of=shot_of,
        observations=observations,
        materials=MATERIALS,
    )


def scaled(outcome: RunResult, factor: float) -> RunResult:
    """A result whose measured values are so many times as large."""
    values = {
        name: replace(each, value=None if each.value is None else factor * each.value)
        for name, each in outcome.measurements.items()
    }
    return replace(outcome, measurements=values)


PROVENANCE: dict[str, str | float] = {"whipple": "0.1.0", "numba": "0.68.1", "physics_version": 1, "seconds": 4.2}


def of_version(outcome: RunResult, quantity: str, version: int) -> RunResult:
    """A result with one of its quantities measured by another version of its definition."""
    changed = {quantity: replace(outcome.measurements[quantity], version=version)}
    return replace(outcome, measurements={**outcome.measurements, **changed})


def measured(value: float, *flags: str) -> Measured:
    times: list[float | None] = [2e-6 * step for step in range(21)]
    grown: list[float | None] = [value * (1 - math.exp(-(2e-6 * step) / 6e-6)) for step in range(21)]
    parts = {"growth": 0.01 * value, "resolution": 0.02 * value}
    history = {"time": times, "value": grown}
    return Measured(value, math.hypot(*parts.values()), parts, flags, history, 1)


def mesh_error(run: Run) -> float:
    """Relative error of a run on its mesh: of another kind for each speed; none where no mesh is named."""
    cells, offset = run.parameters.get("cells_per_diameter"), run.parameters.get("offset", 0.0)
    if cells is None:
        return 0.0
    h = 16.0 / cells  # 1 on the coarsest mesh, 1/4 on the finest
    kinds = {
        2000.0: 0.08 * h,  # first order
        3000.0: 0.08 * h**2,  # second order
        4000.0: 0.04 * math.cos(math.pi * math.log2(h)) * h,  # changes sign with each halving
        5000.0: 0.001 * h,  # nothing that the offsets let see
        6000.0: -0.02 * math.log2(h) ** 2,  # grows with refinement
        7000.0: 0.06 * h**1.5,
    }
    return kinds.get(shot_of(run).speed, 0.08 * h) + 0.004 * h * math.cos(2 * math.pi * offset)


def result(run: Run) -> RunResult:
    """A hole a little wider than the law with the sound speed; a crater near a hemisphere."""
    shot = shot_of(run)
    wavy = (1 + 0.02 * math.sin(shot.speed / 700)) * (1 + mesh_error(run))
    if run.scenario == "thin_plate":
        hole = _maiden_c(shot, "") * DIAMETER * 1.04 * wavy
        clear = measured(hole)
        clear = replace(clear, parts={**clear.parts, DEFINITION: 0.5 * 0.03 * hole})
        values = {"hole_diameter": clear, "hole_diameter_areal": measured(1.03 * hole)}
    else:
        depth = 2.2 * (shot.speed / SOUND_SPEED) ** 0.6 * DIAMETER * wavy
        values = {
            "crater_depth": measured(depth),
            "crater_diameter": measured(1.9 * depth),
            "crater_depth_over_diameter": measured(1 / 1.9),
        }
    cells = run.parameters.get("cells_per_diameter", 32.0)
    return RunResult(
        run.id, "succeeded", measurements=values, numbers=_numbers(shot, cells), stop="converged", provenance=PROVENANCE
    )


def _numbers(shot: Shot, cells: float) -> dict[str, float]:
    return {
        "cells_per_diameter": cells,
        "cells_per_thickness": 4000 * (shot.plate_thickness or 0.04),
        "particles": 40960.0,
        "steps": 3000.0 + shot.speed,
        "end_time": 4e-5,
        "energy_drift": -2e-3 * shot.speed / 7000,
        "momentum_error": 3.1e-14,
        "mass_error": 0.0,
        "hottest_energy_share": 0.013,
        "outflow_mass_fraction": 0.08,
        "separated_mass_fraction": 0.21,
        "tension_floors": 182345.0,
    }


def holes(**changes: Any) -> Sweep:
    """Six speeds by three thicknesses."""
    axes = (Axis("speed", "m s-1", SPEEDS), Axis("plate_thickness", "m", THICKNESSES))
    return replace(Sweep(axes), **changes)


def craters(**changes: Any) -> Sweep:
    """Four speeds on a thick plate."""
    axes = (Axis("speed", "m s-1", SPEEDS[2:]),)
    return replace(Sweep(axes, scenario="thick_plate", title="Craters in copper"), **changes)


def refinements(cells: Sequence[float] = CELLS, offsets: Sequence[float] = OFFSETS) -> Any:
    """Resolutions and offsets as the dimensions of a sweep, where there are several."""
    both = (Axis("cells_per_diameter", "1", tuple(cells)), Axis("offset", "1", tuple(offsets)))
    return tuple(axis for axis in both if len(axis.values) > 1)


def refined_holes(cells: Sequence[float] = CELLS, offsets: Sequence[float] = OFFSETS) -> Sweep:
    """Six speeds, each with another kind of mesh error, at one thickness."""
    fixed = {"projectile_diameter": DIAMETER, "plate_thickness": 2e-3}
    axes = (Axis("speed", "m s-1", SPEEDS),)
    return Sweep(axes, fixed, refinements=refinements(cells, offsets))


def results(sweep: Sweep) -> dict[str, Any]:
    """A result for each run."""
    return {point.run.id: result(point.run) for point in sweep.runs()}


def with_trouble(sweep: Sweep) -> dict[str, Any]:
    """One run failed, one was cancelled, one is coarse and one did not perforate."""
    outcomes = results(sweep)
    first, second, third, fourth = [point.run.id for point in sweep.runs()[:4]]
    outcomes[first] = RunResult(
        first,
        "failed",
        failure="UnphysicalState",
        reason="density = 3e4 at particle 17 of 'target', t = 1.2e-06 s, step 88",
        stop="failed",
        provenance=PROVENANCE,
    )
    outcomes[second] = MissingResult("cancelled", "cancelled by its user")
    outcomes[third] = replace(outcomes[third], flags=("under_resolved",))
    outcomes[fourth] = replace(
        outcomes[fourth],
        measurements={"hole_diameter": replace(measured(0.01, "not_perforated"), value=None, uncertainty=None)},
    )
    return outcomes


def observed(speed: float, thickness: float, value: float, uncertainty: float | None = 0.3e-3) -> Observed:
    at = {"speed": speed, "plate_thickness": thickness, "projectile_diameter": DIAMETER}
    shot = Shot(speed, DIAMETER, thickness)
    return Observed(at, "hole_diameter", value, uncertainty, "Somebody (2001), Table 3", shot)


SHOTS = (
    observed(2600.0, 0.002, 12.4e-3),
    observed(4000.0, 0.003, 17.9e-3),
    observed(5930.0, 0.003, 22.4e-3, None),
    observed(9000.0, 0.004, 30.1e-3),
)
