"""The thesis' thin plate at 6 km/s by both methods on the same particles, and what a step of each method costs."""

import math
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from studies.cases import validation
from studies.cases.compared import ComparedReading
from studies.cubes import cube
from studies.quantities.measured import ENERGY_DRIFT_LIMIT
from studies.runs.execution import execute
from studies.sweeps.sweep import Sweep
from tests.claims.rows import Row, at_most, equal

METHODS = ("mpm", "sph")
# Cells per diameter, two particles in each and direction: the thesis' mesh, and twice 1.5 times as fine a one.
GRIDS = (8, 12, 18)
HOLES = {"hole_diameter": "hole", "hole_diameter_areal": "hole by areal density"}


def document() -> dict[str, Any]:
    """The thesis' sweep at 6 km/s, with the method as an axis and three grids."""
    thesis: Any = validation.load("thesis-holes").documents("thesis")["holes"]
    return {
        **thesis,
        "name": "methods",
        "title": "Hole in a copper plate by two methods: Ma (2005), section 3.1.1",
        "fixed": {**thesis["fixed"], "speed": "6 km/s"},
        "axes": {"method": list(METHODS)},
        "resolution": list(GRIDS),
    }


@pytest.mark.claim("methods", "methods-thin-plate", minutes=25.0)
def test_methods__have_holes_with_error_bars(compared: Callable[[Row], None], tmp_path: Path) -> None:
    """The thesis' plate of 2 mm at 6 km/s has a hole with an error bar by points on a grid and by smoothed particles.

    At the same spacing on three grids: every run ends and keeps its energy. The holes stand beside each other with
    their cost.
    """
    sweep, results, cost = Sweep.parse(document()), {}, {}
    for point in sweep.runs():
        parameters = point.run.parameters
        method = str(parameters["method"])
        where = f"{method}, {parameters['cells_per_diameter']:g} cells per diameter"
        begin = time.process_time()
        result = results[point.run.id] = execute(point.run, tmp_path / point.run.id, threads=1)
        cost[method] = time.process_time() - begin
        compared(equal(f"{where}: state of the run", expected="succeeded", got=result.state))
        drift = abs(result.numbers["largest_energy_drift"])
        compared(at_most(f"{where}: largest drift of the energy", limit=ENERGY_DRIFT_LIMIT, got=drift))
        compared(Row(f"{where}: processor time (s)", "", cost[method], None))
        steps = result.numbers["particle_steps"]
        compared(Row(f"{where}: of a particle-step (ns)", "", 1e9 * cost[method] / steps, None))
    compared(Row("sph over mpm on the finest grid: cost", "", cost["sph"] / cost["mpm"], None))
    dataset = cube.build(sweep, results)
    for name, says in HOLES.items():
        readings = [ComparedReading(dataset, name, {"method": method}) for method in METHODS]
        for method, reading in zip(METHODS, readings, strict=True):
            value, bar = reading.best
            claim = f"{method}: {says} (mm), {reading.convergence}"
            compared(Row(claim, "a value with its bar", value, math.isfinite(value) and bar is not None, bar=bar))
        (mpm, mpm_bar), (sph, sph_bar) = (reading.point for reading in readings)
        compared(Row(f"{says}: sph less mpm (mm)", "", sph - mpm, None, bar=math.hypot(mpm_bar, sph_bar)))
