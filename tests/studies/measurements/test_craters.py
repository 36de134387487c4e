"""Crater diameters: walls of known shape, and those of the demo beside a fit of the wall that is made another way."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from studies.measurements._settings import ImpactSetting
from studies.measurements.impact.view import ImpactView, view
from studies.runs.execution import execute
from studies.runs.remeasure import load_state
from studies.runs.stages import setting_of
from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from studies.sweeps.sweep import Sweep
from tests.claims.rows import Row, absolute, at_most
from tests.studies.measurements.states import CELL, CRATER, WALLS, cratered, value

TENTH = 0.1  # of a cell, on each side
APART = 0.3  # mm between a diameter and the fit of its wall
UPPER = 0.5  # of the crater's depth: where its wall is fitted


@pytest.mark.claim("craters", "crater-walls")
def test_crater_diameter__of_known_walls(compared: Callable[[Row], None]) -> None:
    """Cylinders, spheres, paraboloids and cones cut out of a block have their diameter to a tenth of a cell a side."""
    for shape, wall in WALLS.items():
        diameter = value("crater_diameter", cratered(wall, CRATER)) / CELL
        compared(absolute(f"{shape} (cells)", expected=2.0 * CRATER / CELL, got=diameter, within=2.0 * TENTH))


@pytest.mark.claim("craters", "demo-craters", minutes=20.0)
def test_demo_craters__have_settled_and_have_the_diameter_of_their_wall(
    compared: Callable[[Row], None], tmp_path: Path
) -> None:
    """The demo's craters stay inside their bars for the last settling window, and are within 0.3 mm of a wall's fit."""
    for point in Sweep.parse(read_yaml(examples.text("craters"), "craters")).runs():
        run, folder = point.run, tmp_path / point.run.id
        measurements = execute(run, folder, threads=1).measurements
        speed, window = (float(str(run.parameters[name])) for name in ("speed", "settled_window"))
        where = f"{speed / 1e3:g} km/s (mm)"
        for name in ("crater_depth", "crater_diameter"):
            measured = measurements[name]
            assert measured.value is not None
            assert measured.uncertainty is not None
            times, values = (np.array(measured.history[key], float) for key in ("time", "value"))
            last = values[times >= times[-1] - window * (1.0 + 1e-9)]
            farthest = 1e3 * float(np.abs(last - measured.value).max())
            text = f"farthest from the final {name.replace('_', ' ')} in the last window, {where}"
            compared(at_most(text, limit=1e3 * measured.uncertainty, got=farthest))
        depth, diameter = (measurements[name].value for name in ("crater_depth", "crater_diameter"))
        assert depth is not None
        assert diameter is not None
        setting = setting_of(run)
        assert isinstance(setting, ImpactSetting)
        fitted = fitted_diameter(view(setting, load_state(folder / "state.npz")), depth)
        text = f"diameter and fit of the wall, {where}"
        compared(absolute(text, expected=1e3 * fitted, got=1e3 * diameter, within=APART))


def fitted_diameter(state: ImpactView, depth: float) -> float:
    """Diameter at the surface of the conic of revolution, r^2 quadratic in z, through the upper half of a wall.

    In each row of a cell's height the wall begins half a cell before the place where half a cell is filled, counted
    from the axis: no density and no window, as the measurement has them.
    """
    lows = np.arange(0.0, UPPER * depth, state.cell)
    squares = []
    for low in lows:
        row = state.attached & (state.depth >= low) & (state.depth < low + state.cell)
        order = np.argsort(state.radius[row])
        radius = state.radius[row][order]
        filled = np.cumsum(state.mass[row][order] / (state.density * radius))
        half = np.searchsorted(filled, 0.5 * state.cell**2)
        squares.append((radius[half] - 0.5 * state.cell) ** 2)
    return float(2.0 * np.sqrt(np.polyfit(lows + 0.5 * state.cell, squares, 2)[-1]))
