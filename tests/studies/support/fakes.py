"""Sweeps with invented results, and laws that suit them: smooth numbers, so that cube and report are tested alone."""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import xarray as xr

from studies import laws, materials, scenarios
from studies.convergence.richardson import SAFETY
from studies.cubes import cube
from studies.cubes.catalogue import Catalogue, Observed
from studies.cubes.variable import Quantity
from studies.laws import NOT_FOUND, Law, Range, Shot
from studies.laws._range import speed
from studies.quantities.measured import DEFINITION, Measured
from studies.quantities.parameters import declared
from studies.reports import report
from studies.runs.results import RunResult
from studies.runs.run import Run
from studies.sweeps.axes import Axis
from studies.sweeps.sweep import Sweep

DIAMETER = 0.008
CELLS = (16.0, 32.0, 64.0)
OFFSETS = 3
SPEEDS = (2000.0, 3000.0, 4000.0, 5000.0, 6000.0, 7000.0)
THICKNESSES = (0.002, 0.003, 0.004)
SOUND_SPEED = 3940.0
VERDICTS = {  # of refinement, by speed: see mesh_error
    2e3: "converging",
    3e3: "converging",
    4e3: "order unknown",
    5e3: "order unknown",
    6e3: "order unknown",
    7e3: "converging",
}


COPPER = materials.load("copper-ofhc")
NUMBERS = {path: asdict(number) for path, number in COPPER.sources.items()}
FIXED = {"speed": 5e3, "projectile_diameter": DIAMETER, "projectile": "copper-ofhc", "target": "copper-ofhc"}
METHODS = Axis("method", None, ("mpm", "sph"))
BY_BOTH = {"geometry": "quarter"}  # which both methods compute
UNREFINED = 20.0  # cells per diameter of a sweep that names no resolution: a mesh without an error


def sweep_of(*axes: Axis, **changes: Any) -> Sweep:
    """A sweep over some axes."""
    plain: dict[str, Any] = {
        "name": "invented",
        "title": "Holes in copper plates",
        "scenario": "thin_plate",
        "combine": "grid",
        "resolutions": (UNREFINED,),
    }
    holes = changes.get("scenario", "thin_plate") == "thin_plate"
    fixed = FIXED | ({"plate_thickness": 2e-3} if holes else {}) | changes.pop("fixed", {})
    varied = {axis.name for axis in axes}
    fixed = {name: value for name, value in fixed.items() if name not in varied}
    return Sweep(axes=axes, fixed=fixed, **{**plain, **changes})


def law(name: str, quantity: str, ratio: Callable[[Shot, str], float], **changes: Any) -> Law:
    """A law of tests, without a limit that its source states unless one is given."""
    plain = {
        "title": "a law of the tests",
        "equation": "D/d = f(v, t/d)",
        "source": "Nobody (1999), Eq. 1",
        "confidence": "read",
        "range": within(0.0, math.inf),
    }
    return Law(name=name, quantity=quantity, ratio=ratio, **{**plain, **changes})


def within(low: float, high: float, source: str = "Nobody (1999)") -> Range:
    """A range of speeds, km/s."""
    return Range(speed(low, high, source), projectile=speed(0.0, math.inf, NOT_FOUND))


def shipped(name: str, title: str, range: Range) -> Law:
    """A law that ships, with a range that some of the invented runs meet."""
    return replace(laws.load(name), title=title, range=range)


HOLE_LAWS = (
    shipped("maiden_al", "thesis 1-3, aluminium", within(2.5, 5.5)),
    shipped("maiden_c", "general form with the sound speed", within(0.0, math.inf)),
    shipped("zhang_tan", "thesis 1-4", within(0.0, math.inf)),
    shipped("strength_ln", "thesis 1-5", within(0.0, 0.001)),
)
YIELDS = HOLE_LAWS[3].variants(Shot(5e3, DIAMETER, 2e-3, COPPER, COPPER))
CRATER_LAWS = (
    law("charters_summers", "crater_depth", lambda shot, _: 2.28 * (shot.speed / 3940) ** (2 / 3)),
    law("two_thirds", "crater_depth", lambda shot, _: 0.431 * 8.93 ** (1 / 3) * (shot.speed / 1e3) ** (2 / 3)),
)


HOLES = {
    "hole_diameter": Quantity("hole_diameter", "m", "clear opening"),
    "hole_diameter_areal": Quantity("hole_diameter_areal", "m", "opening by areal density", first=False),
}
CRATERS = {
    "crater_depth": Quantity("crater_depth", "m", "depth from the original surface"),
    "crater_diameter": Quantity("crater_diameter", "m", "diameter at the original surface"),
    "crater_depth_over_diameter": Quantity("crater_depth_over_diameter", "1", "depth over diameter", first=False),
}


def cube_of(sweep: Sweep, outcomes: Mapping[str, RunResult] | None = None, **changes: Any) -> xr.Dataset:
    """The cube of a sweep with invented results, and with changes to its catalogue."""
    return cube.build(sweep, results(sweep) if outcomes is None else outcomes, catalogue(sweep.scenario, **changes))


def catalogue(scenario: str = "thin_plate", **changes: Any) -> Catalogue:
    """What suits the invented results, with changes."""
    holes = scenario == "thin_plate"
    plain: dict[str, Any] = {
        "title": "Perforation of a thin plate" if holes else "Crater in a thick plate",
        "parameters": declared(scenarios.load(scenario).parameters),
        "quantities": HOLES if holes else CRATERS,
        "laws": HOLE_LAWS if holes else CRATER_LAWS,
        "shot_of": lambda run: laws.shot_from(run.parameters, run.materials),
        "materials": {"copper-ofhc": {"title": COPPER.title, "numbers": NUMBERS}},
    }
    return Catalogue(**plain | changes)


def scaled(outcome: RunResult, factor: float) -> RunResult:
    """A result whose measured values are so many times as large."""
    values = {
        name: replace(each, value=None if each.value is None else factor * each.value)
        for name, each in outcome.measurements.items()
    }
    return replace(outcome, measurements=values)


PROVENANCE: dict[str, str | float] = {"whipple": "0.1.0", "numba": "0.68.1", "physics_version": 1, "seconds": 4.2}


def measured(value: float, *flags: str) -> Measured:
    times: list[float | None] = [2e-6 * step for step in range(21)]
    grown: list[float | None] = [value * (1 - math.exp(-(2e-6 * step) / 6e-6)) for step in range(21)]
    parts = {"growth": 0.01 * value, "resolution": 0.02 * value}
    history = {"time": times, "value": grown}
    return Measured(value, math.hypot(*parts.values()), parts, flags, history, 1)


def of_first_order(value: float, share: float, run: Run) -> Measured:
    """A reading on the grid of a run; the finest grid has the value, and a mesh error (GCI) of a share of it."""
    cells = float(run.parameters["cells_per_diameter"] or 0.0)
    coarser = CELLS[-1] / cells - 1.0 if cells in CELLS else 0.0
    return Measured(value * (1.0 + share / SAFETY * coarser), share * value, {}, (), {}, 1)


def mesh_error(run: Run) -> float:
    """Relative error of a run on its mesh: of another kind for each speed; none where no mesh is named."""
    cells, offset = (float(run.parameters[name] or 0.0) for name in ("cells_per_diameter", "offset"))
    if cells not in CELLS:
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
    return kinds.get(float(run.parameters["speed"] or 0.0), 0.08 * h) + 0.004 * h * math.cos(2 * math.pi * offset)


def result(run: Run) -> RunResult:
    """A hole a little wider than the law with the sound speed; a crater near a hemisphere."""
    shot = laws.shot_from(run.parameters, run.materials)
    wavy = (1 + 0.02 * math.sin(shot.speed / 700)) * (1 + mesh_error(run))
    if run.scenario == "thin_plate":
        hole = float(HOLE_LAWS[1].ratio(shot, "")) * DIAMETER * 1.04 * wavy
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
    cells = float(run.parameters["cells_per_diameter"] or 0.0)
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
    return sweep_of(Axis("speed", "m s-1", SPEEDS), Axis("plate_thickness", "m", THICKNESSES), **changes)


def craters(**changes: Any) -> Sweep:
    """Four speeds on a thick plate."""
    axis = Axis("speed", "m s-1", SPEEDS[2:])
    return sweep_of(axis, scenario="thick_plate", title="Craters in copper", **changes)


def refined_holes(cells: Sequence[float] = CELLS, offsets: int = OFFSETS, **changes: Any) -> Sweep:
    """Six speeds, each with another kind of mesh error, at one thickness."""
    axis = Axis("speed", "m s-1", SPEEDS)
    return sweep_of(axis, resolutions=tuple(cells), offsets=offsets, **changes)


def results(sweep: Sweep) -> dict[str, Any]:
    """A result for each run."""
    return {point.run.id: result(point.run) for point in sweep.runs()}


def searched(sweep: Sweep, result_of: Callable[[Run], RunResult]) -> dict[str, RunResult]:
    """The results of the runs that the search of a sweep asks for."""
    outcomes: dict[str, RunResult] = {}
    [quantity] = [axis.search.quantity for axis in sweep.axes if axis.search]

    def outcome_of(run: Run) -> bool:
        outcomes[run.id] = result_of(run)
        return outcomes[run.id].measurements[quantity].value == 1.0

    sweep.limits(outcome_of)
    return outcomes


def document_of(dataset: xr.Dataset) -> dict[str, Any]:
    """The report of a cube as a program reads it."""
    document: dict[str, Any] = json.loads(report.as_json(report.report_of(dataset).as_json()))
    return document


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
    outcomes[second] = RunResult("", "cancelled", "cancelled by its user")
    outcomes[third] = replace(outcomes[third], flags=("under_resolved",))
    outcomes[fourth] = replace(
        outcomes[fourth],
        measurements={"hole_diameter": replace(measured(0.01, "not_perforated"), value=None, uncertainty=None)},
    )
    return outcomes


def observed(speed: float, thickness: float, value: float, uncertainty: float | None = 0.3e-3) -> Observed:
    at = {"speed": speed, "plate_thickness": thickness, "projectile_diameter": DIAMETER}
    shot = Shot(speed, DIAMETER, thickness, COPPER, COPPER)
    return Observed("hole_diameter", value, uncertainty, "Somebody (2001), Table 3", at, shot=shot)


SHOTS = (
    observed(2600.0, 0.002, 12.4e-3),
    observed(4000.0, 0.003, 17.9e-3),
    observed(5930.0, 0.003, 22.4e-3, None),
    observed(9000.0, 0.004, 30.1e-3),
)
