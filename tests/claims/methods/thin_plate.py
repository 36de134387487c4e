"""The thesis' thin plate at 6 km/s by both methods on the same particles: holes with error bars, and what they cost."""

import math
import tempfile
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from studies import validation
from studies.cubes import cube
from studies.runs.execution import execute
from studies.sweeps.sweep import Sweep
from studies.validation._compare import ComparedReading
from studies.values.results import ENERGY_DRIFT_LIMIT, RunResult
from tests.claims import Row, at_most, claim, equal

METHODS = ("mpm", "sph")
# Cells per diameter, two particles in each and direction: the thesis' mesh, and twice 1.5 times as fine a one.
GRIDS = (8, 12, 18)
HOLES = {"hole_diameter": "hole", "hole_diameter_areal": "hole by areal density"}


@dataclass(frozen=True)
class Computed:
    """A sweep with its results and the processor time of each run (s), by the run's id."""

    sweep: Sweep
    results: Mapping[str, RunResult]
    seconds: Mapping[str, float]


def document() -> dict[str, Any]:
    """The thesis' sweep at 6 km/s, with the method as an axis and three grids."""
    thesis = validation.load("thesis-holes").documents("thesis")["holes"]
    return {
        **thesis,
        "name": "methods",
        "title": "Hole in a copper plate by two methods: Ma (2005), section 3.1.1",
        "fixed": {**thesis["fixed"], "speed": "6 km/s"},
        "axes": {"method": list(METHODS)},
        "resolution": list(GRIDS),
    }


def compute(folder: Path) -> Computed:
    """Compute the sweep; the files of each run go to a folder of its id."""
    sweep, results, seconds = Sweep.parse(document()), {}, {}
    for point in sweep.runs():
        begin = time.process_time()
        results[point.run.id] = execute(point.run, folder / point.run.id, threads=1)
        seconds[point.run.id] = time.process_time() - begin
    return Computed(sweep, results, seconds)


@claim(
    "methods-thin-plate",
    says="the thesis' plate of 2 mm at 6 km/s is computed by material points and by smoothed particles at the same "
    "spacing on three grids: every run ends and keeps its energy, and both holes have an error bar; they stand beside "
    "each other with their cost",
    minutes=25.0,
)
def methods_thin_plate() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as folder:
        computed = compute(Path(folder))
    yield from rows(computed)


def rows(computed: Computed) -> Iterator[Row]:
    """Gated is that the comparison is one; the holes are shown."""
    cost = dict.fromkeys(METHODS, 0.0)
    for point in computed.sweep.runs():
        result, parameters = computed.results[point.run.id], point.run.parameters
        method = str(parameters["method"])
        where = f"{method}, {parameters['cells_per_diameter']:g} cells per diameter"
        yield equal(f"{where}: state of the run", expected="succeeded", got=result.state)
        drift = abs(result.numbers["largest_energy_drift"])
        limit = ENERGY_DRIFT_LIMIT
        yield at_most(f"{where}: largest drift of the energy", limit=limit, got=drift)
        cost[method] = computed.seconds[point.run.id]
        yield Row(f"{where}: processor time (s)", "", cost[method], None)
        steps = result.numbers["particle_steps"]
        yield Row(f"{where}: of a particle-step (ns)", "", 1e9 * cost[method] / steps, None)
    yield Row("sph over mpm on the finest grid: cost", "", cost["sph"] / cost["mpm"], None)
    yield from _holes(computed)


def _holes(computed: Computed) -> Iterator[Row]:
    dataset = cube.build(computed.sweep, computed.results)
    for name, says in HOLES.items():
        readings = {method: ComparedReading(dataset, name, {"method": method}) for method in METHODS}
        for method, reading in readings.items():
            value, bar, verdict = reading.converged
            grids = ", ".join(f"{reading.on(grid):.4g}" for grid in reading.grids)
            claimed = f"{method}: {says} (mm), {verdict}; grids {grids}"
            gated = math.isfinite(value) and math.isfinite(bar)
            yield Row(claimed, "a value with its bar", value, gated, bar=bar)
        (mpm, mpm_bar, _), (sph, sph_bar, _) = (readings[method].converged for method in METHODS)
        apart = sph - mpm
        yield Row(f"{says}: sph less mpm (mm)", "", apart, None, bar=math.hypot(mpm_bar, sph_bar))
