"""The demo: bars beside a finer grid, and its time from a fresh clone."""

import os
import re
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

import whipple
from service.cli.commands.computing import DEMO
from studies.cases.rows import Row, at_least, at_most, equal
from studies.quantities.files import SWEEP_FILES
from studies.quantities.measured import ENERGY_DRIFT_LIMIT
from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from tests.claims.marked import Compared
from tests.crash.support.serving import ROOT

FINE, SPEEDS = 64, ("2 km/s", "4 km/s", "6 km/s")  # twice the cells of the demo's finest grid


def computed(document: dict[str, Any], folder: Path) -> xr.Dataset:
    return xr.load_dataset(whipple.run_sweep(document, folder, keep="numbers") / "cube.nc")


@pytest.mark.claim("mend-again", "demo-series", minutes=4.0)
def test_demo__has_bars_that_hold_a_finer_grid(tmp_path: Path, compared: Compared) -> None:
    """Bars of the holes of the demo hold a grid twice as fine."""
    document = read_yaml(examples.text("holes"), "holes")
    cube = computed(document, tmp_path / "holes")
    axes = {"axes": {"speed": list(SPEEDS)}, "resolution": FINE, "offsets": 1}
    fine = computed(document | axes, tmp_path / "fine")
    for speed in fine.speed.values:
        coarse = cube.sel(speed=speed)
        error = abs(float(fine.hole_diameter.sel(speed=speed) - coarse.hole_diameter_converged))
        bar = float(coarse.hole_diameter_converged_uncertainty)
        label = f"hole at {speed / 1e3:g} km/s: from the value to that on {FINE} cells (mm)"
        compared(at_most(label, limit=1e3 * bar, got=1e3 * error))


SHAPES = {
    "holes": {"speed": 6},
    "aluminium": {"speed": 3, "plate_thickness": 2},
    "sphere": {"speed": 1},
    "craters": {"speed": 3},
    "shield": {"failure": 2},
}


@pytest.mark.claim("demo", "demo", minutes=5.0)
@pytest.mark.claim("speed", "demo-time", minutes=5.0)
def test_demo__takes_less_than_five_minutes(tmp_path: Path, compared: Compared) -> None:
    """make demo takes less than five minutes from a fresh clone on two idle cores, on 16 and 24 cells per diameter.

    Neither environment nor kernels are there. Each hole is computed on at least 3 cells through the plate, and the
    energy of each run is kept within 1 %.
    """
    clone = tmp_path / "whipple"
    subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
    begin = time.perf_counter()
    environment = {**os.environ, "WHIPPLE_KERNEL_CACHE": f"{tmp_path}/kernels"}
    made = subprocess.run(["make", "demo"], cwd=clone, env=environment, capture_output=True, text=True, check=False)
    seconds = time.perf_counter() - begin
    compared(equal("exit status", expected=0, got=made.returncode))
    for line in made.stdout.splitlines():
        if re.match(r"set up in|kernels:|wall time|\w+: \d+ succeeded", line):
            compared(Row("stage", "", line, None))
    compared(at_most("the whole (s)", limit=300.0, got=seconds))
    for name in DEMO:
        folder = clone / "demo" / name
        there = {file.name for file in folder.iterdir()} & {*SWEEP_FILES}
        compared(equal(f"{name}: files", expected={*SWEEP_FILES}, got=there))
        cube = xr.load_dataset(folder / "cube.nc")
        sizes = {axis: int(cube.sizes[axis]) for axis in SHAPES[name]}
        compared(equal(f"{name}: axes", expected=SHAPES[name], got=sizes))
        drift = float(abs(cube["audit_largest_energy_drift"]).max())
        compared(at_most(f"{name}: largest energy drift of any run", limit=ENERGY_DRIFT_LIMIT, got=drift))
        if "hole_diameter" in cube:
            cells = cube["cells_per_diameter"]
            grids = sorted(set(cells.values.ravel().tolist()))
            compared(at_least(f"{name}: grids of at least 16 cells per diameter", limit=2, got=len(grids)))
            compared(at_least(f"{name}: cells per diameter, coarsest", limit=16.0, got=grids[0]))
            compared(at_least(f"{name}: cells per diameter, finest", limit=24.0, got=grids[-1]))
            through = cells * cube["plate_thickness"] / cube["projectile_diameter"]
            compared(at_least(f"{name}: cells through a plate", limit=3.0, got=float(through.min())))
