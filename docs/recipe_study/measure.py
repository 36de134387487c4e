"""Measurements of each variant: problems with exact solutions, the hole, the crater, and the cost of each."""

import math
import tempfile
import time
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from typing import Any

from solver.errors import WhippleError
from studies.cases.setups.runs import executed
from studies.cases.solutions.hugoniot import Solid
from studies.cases.validation.taylor_bar import HALVED, MATERIAL, MEASURED, REFERENCES
from studies.cases.verification.contact import contact_and_rebound
from studies.cases.verification.noh import gated_errors
from studies.cases.verification.plate_impact import PAIRS, impact, states
from studies.quantities.numerical_defaults import Recipe
from studies.runs.execution import execute
from studies.runs.results import RunResult
from studies.sweeps.sweep import Sweep

SPEEDS = (2e3, 6e3)  # m/s
HOLE_CELLS = (16, 32)  # across the diameter: 4 and 8 through the plate
CRATER_CELLS = 8  # coarse: it compares recipes, it does not predict

# Of the candidates.
FINAL_SPEEDS = (2e3, 4e3, 6e3)  # m/s
FINAL_CELLS = (16, 32, 64)
OFFSETS = (0.0, 1.0 / 3.0, 2.0 / 3.0)  # places of the target against the grid, in cells

Figures = dict[str, Any]


def known(recipe: Recipe) -> Figures:
    """The figures of a recipe that have a known answer."""
    return {
        "recipe": asdict(recipe),
        "shocks": {
            f"{flyer.name} on {target.name}, {speed:g}": shock(recipe, flyer, target, speed)
            for flyer, target, speed in PAIRS
        },
        "bar": bar(recipe),
        "taylor": taylor(recipe),
        "noh": noh(recipe),
        "coarse_hole": hole(recipe, SPEEDS[-1], HOLE_CELLS[0]),
    }


def measured(recipe: Recipe) -> Figures:
    """Every figure of a recipe."""
    return {
        **known(recipe),
        "holes": {f"{speed:g}": {str(cells): hole(recipe, speed, cells) for cells in HOLE_CELLS} for speed in SPEEDS},
        "crater": crater(recipe),
    }


def shock(recipe: Recipe, flyer: Solid, target: Solid, speed: float) -> Figures:
    """Relative errors of the states behind both shocks of a plate impact."""
    begin = time.process_time()
    try:
        result = impact(flyer, target, speed, recipe)
    except WhippleError as error:
        return {"state": "failed", "reason": str(error)}
    both = [(exact, wave) for _, exact, wave in states(flyer, target, speed, result)]
    return {
        "state": "succeeded",
        "pressure": [w.plateau.stress / s.pressure - 1.0 for s, w in both],
        "scatter": [w.plateau.scatter for _, w in both],
        "shock_speed": [w.speed / s.shock_speed - 1.0 for s, w in both],
        "particle_density": [w.plateau.density / s.density - 1.0 for s, w in both],
        "spacing_density": [w.plateau.spacing_density / s.density - 1.0 for s, w in both],
        "energy": [w.plateau.energy / s.energy - 1.0 for s, w in both],
        "energy_drift": result.outcome.audit.energy_drift,
        "seconds": time.process_time() - begin,
    }


def bar(recipe: Recipe) -> Figures:
    """The elastic bar on a wall."""
    try:
        contact, rebound = contact_and_rebound(recipe)
    except WhippleError as error:
        return {"state": "failed", "reason": str(error)}
    return {"state": "succeeded", "time": contact, "rebound": rebound}


def final_hole(recipe: Recipe, speed: float, cells: int, offset: float) -> tuple[float, float]:
    """Diameter of the hole at one sub-cell position (m; NaN without one), and its processor seconds."""
    figures = hole(recipe, speed, cells, offset)
    return float(figures.get("hole_diameter") or math.nan), float(figures["seconds"])


def taylor(recipe: Recipe) -> Figures:
    """The Taylor bar on the thesis' grid and on finer ones: mean changes from grid to grid, and errors.

    Both are Eq. 2-42: of a grid against the next finer one, and against the experiment.
    """
    try:
        bars = [_taylor_bar(recipe, cells) for cells in HALVED]
    except WhippleError as failure:
        return {"state": "failed", "reason": str(failure)}
    changes = [
        sum(abs(coarse[name] / fine[name] - 1.0) for name in MEASURED) / len(MEASURED)
        for coarse, fine in pairwise(bars)
    ]
    return {
        "state": "succeeded",
        "changes": changes,
        "mean_error": bars[0]["taylor_error"],
        "finest_error": bars[-1]["taylor_error"],
    }


def _taylor_bar(recipe: Recipe, cells: float) -> dict[str, float]:
    """The three lengths of the body of revolution, m, and their mean error against the experiment (Eq. 2-42)."""
    parameters = {"cells_per_diameter": cells, **REFERENCES}
    result = executed("taylor_bar", recipe, parameters, {"bar": MATERIAL})
    return {name: _value(result, name) for name in (*MEASURED, "taylor_error")}


def _value(result: RunResult, name: str) -> float:
    """A measured value; NaN where there is none."""
    measured = result.measurements[name].value
    return float("nan") if measured is None else float(measured)


def noh(recipe: Recipe) -> Figures:
    """Noh's implosions on a plane and on an axis: the largest error, as a part of its gate."""
    try:
        errors = gated_errors(recipe)
    except WhippleError as failure:
        return {"state": "failed", "reason": str(failure)}
    return {"state": "succeeded", "part": max(errors.values())}


def hole(recipe: Recipe, speed: float, cells: int, offset: float = 0.0) -> Figures:
    """The hole in a copper plate of a quarter of the sphere's diameter."""
    fixed = {"projectile_diameter": "8 mm", "plate_thickness": "2 mm"}
    copper = {"projectile": "copper-ofhc", "target": "copper-ofhc"}
    return computed("thin_plate", recipe, speed, cells, {**fixed, **copper, "offset": offset})


def crater(recipe: Recipe) -> Figures:
    """The crater of the thesis' thick plate: Ma (2005), section 3.2.1."""
    fixed = {"projectile_diameter": "4.75 mm", "target_depth": "40 mm"}
    copper = {"projectile": "copper-thesis-plastic", "target": "copper-thesis-plastic"}
    return computed("thick_plate", recipe, 6e3, CRATER_CELLS, {**fixed, **copper})


def computed(scenario: str, recipe: Recipe, speed: float, cells: int, fixed: dict[str, Any]) -> Figures:
    """The figures of one run with the numerics of a recipe."""
    document = {
        "name": "recipe",
        "scenario": scenario,
        "fixed": {**fixed, **_given(recipe)},
        "axes": {"speed": [f"{speed:g} m/s"]},
        "resolution": cells,
    }
    (point,) = Sweep.parse(document).runs()
    begin = time.process_time()
    with tempfile.TemporaryDirectory() as directory:
        result = execute(point.run, Path(directory), threads=1)
    return _figures(result, time.process_time() - begin)


def _given(recipe: Recipe) -> dict[str, Any]:
    """A recipe as a document states it."""
    plain = asdict(recipe)
    return {**plain, "damping_rate": f"{recipe.damping_rate:g} 1/s"}


def _figures(result: RunResult, seconds: float) -> Figures:
    if result.state != "succeeded":
        return {"state": result.state, "reason": result.reason, "seconds": seconds}
    kept = (
        "energy_drift",
        "hottest_energy_share",
        "largest_speed",
        "separated_mass_fraction",
        "tension_floors",
        "particle_steps",
        "steps",
    )
    return {
        "state": result.state,
        **{name: measured.value for name, measured in result.measurements.items()},
        **{name: result.numbers[name] for name in kept},
        "flags": list(result.flags),
        "seconds": seconds,
    }
