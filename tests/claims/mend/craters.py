"""Crater diameters: walls of known shape, and those of the demo beside a fit of the wall that is made another way."""

import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from studies import examples
from studies.measurements._impact import ImpactView, view
from studies.runs.execution import execute, setting_of
from studies.runs.remeasure import load_state
from studies.runs.run import Run
from studies.sweeps.document import read_yaml
from studies.sweeps.sweep import Sweep
from studies.values.results import RunResult
from tests.claims import Row, absolute, at_most, claim
from tests.studies.measurements.states import CELL, CRATER, WALLS, cratered, value

WORKERS = 2  # processes of one thread each
TENTH = 0.1  # of a cell, on each side
APART = 0.3  # mm between a diameter and the fit of its wall
UPPER = 0.5  # of the crater's depth: where its wall is fitted


@dataclass(frozen=True)
class Crater:
    """A crater of the demo, and the fit of its wall."""

    speed: float  # m/s
    window: float  # over which it settled, s
    result: RunResult
    fitted: float  # diameter, m


@claim(
    "crater-walls",
    says="cylinders, spheres, paraboloids and cones cut out of a block have their diameter to a tenth of a cell a side",
    quick=True,
)
def crater_walls() -> Iterator[Row]:
    for shape, wall in WALLS.items():
        diameter = value("crater_diameter", cratered(wall, CRATER)) / CELL
        yield absolute(f"{shape} (cells)", expected=2.0 * CRATER / CELL, got=diameter, within=2.0 * TENTH)


@claim(
    "demo-craters",
    says="the demo's craters lie inside their error bars for the last settling window, and their diameters within "
    "0.3 mm of a fit of the wall",
)
def demo_craters() -> Iterator[Row]:
    document = read_yaml(examples.text("craters-full"), "craters-full")
    runs = [point.run for point in Sweep.parse(document).runs()]
    with ProcessPoolExecutor(WORKERS, mp_context=get_context("spawn")) as pool:
        for crater in pool.map(computed, runs):
            where = f"{crater.speed / 1e3:g} km/s (mm)"
            measured = crater.result.measurements["crater_diameter"]
            assert measured.value is not None
            yield absolute(
                f"diameter and fit of the wall, {where}",
                expected=crater.fitted * 1e3,
                got=measured.value * 1e3,
                within=APART,
            )
            for name in ("crater_depth", "crater_diameter"):
                yield _within_bar(f"{name.replace('_', ' ')}, {where}", name, crater)


def computed(run: Run) -> Crater:
    """Compute a crater, and fit its wall in the final state."""
    with tempfile.TemporaryDirectory() as folder:
        result = execute(run, Path(folder), threads=1)
        state = view(setting_of(run), load_state(Path(folder) / "state.npz"))
    depth = result.measurements["crater_depth"].value
    assert depth is not None
    speed, window = (float(str(run.parameters[name])) for name in ("speed", "settled_window"))
    return Crater(speed, window, result, fitted_diameter(state, depth))


def fitted_diameter(state: ImpactView, depth: float) -> float:
    """Diameter at the surface of the conic of revolution, r^2 quadratic in z, through the upper half of a wall.

    In each row of a cell's height the wall begins half a cell before the place where half a cell is filled, counted
    from the axis: no density and no window, as the measurement has them.
    """
    lows = np.arange(0.0, UPPER * depth, state.cell)
    squares = [_begin(state, low) ** 2 for low in lows]
    return float(2.0 * np.sqrt(np.polyfit(lows + 0.5 * state.cell, squares, 2)[-1]))


def _begin(state: ImpactView, low: float) -> float:
    row = state.attached & (state.depth >= low) & (state.depth < low + state.cell)
    order = np.argsort(state.radius[row])
    radius = state.radius[row][order]
    filled = np.cumsum(state.mass[row][order] / (state.density * radius))
    half = np.searchsorted(filled, 0.5 * state.cell**2)
    return float(radius[half] - 0.5 * state.cell)


def _within_bar(label: str, name: str, crater: Crater) -> Row:
    """The history over the last window about the final value, beside the error bar."""
    measured = crater.result.measurements[name]
    assert measured.value is not None
    assert measured.uncertainty is not None
    times, values = (np.array(measured.history[key], float) for key in ("time", "value"))
    last = values[times >= times[-1] - crater.window * (1.0 + 1e-9)]
    return at_most(
        f"farthest from the final {label} in the last window; bar {measured.uncertainty * 1e3:.2f}",
        limit=measured.uncertainty * 1e3,
        got=float(np.abs(last - measured.value).max()) * 1e3,
    )
