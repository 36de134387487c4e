"""The demo's sweeps, computed: one rule of extrapolation for a curve, and bars beside a finer grid."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

import whipple
from service.cli.commands.computing import DEMO
from studies import examples
from studies.cubes.points import refined
from studies.cubes.reading import quantities_of
from studies.sweeps.document import read_yaml
from tests.rows import Row, at_most

FINE, SPEEDS = 64, ("2 km/s", "4 km/s", "6 km/s")  # twice the cells of the demo's finest grid


def computed(document: dict[str, Any], folder: Path) -> xr.Dataset:
    """The cube of a sweep."""
    return xr.load_dataset(whipple.run_sweep(document, folder, keep="numbers") / "cube.nc")


@pytest.mark.claim("mend-again", "demo-series", minutes=7.0)
def test_demo__extrapolates_whole_curves_and_its_bars_hold_a_finer_grid(
    tmp_path: Path, compared: Callable[[Row], None]
) -> None:
    """No curve of the demo mixes extrapolated and computed values; bars of its holes hold a grid twice as fine."""
    for name in DEMO:
        document = read_yaml(examples.text(name), name)
        cube = computed(document, tmp_path / name)
        for quantity in quantities_of(cube):
            points = [point.converged for point in refined(cube, quantity)]
            rules = sorted({point.rule for point in points if point.verdict != "no value"})
            label = f"{name}, {quantity}: rules of its values ({', '.join(rules)})"
            compared(at_most(label, limit=1, got=len(rules)))
        if name == "holes":
            axes = {"axes": {"speed": list(SPEEDS)}, "resolution": FINE, "offsets": 1}
            fine = computed(document | axes, tmp_path / "fine")
            for speed in fine.speed.values:
                coarse = cube.sel(speed=speed)
                error = abs(float(fine.hole_diameter.sel(speed=speed) - coarse.hole_diameter_converged))
                bar = float(coarse.hole_diameter_converged_uncertainty)
                label = f"hole at {speed / 1e3:g} km/s: from the value to that on {FINE} cells (mm)"
                compared(at_most(label, limit=1e3 * bar, got=1e3 * error))
