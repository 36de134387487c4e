"""The demo: its holes beside a finer grid, and its cost from a fresh clone."""

import os
import re
import resource
import subprocess
import time
from pathlib import Path
from typing import Any

import pytest
import xarray as xr

import whipple
from service.demo.commands import DEMO
from studies.cubes.opening import whole_cube
from studies.quantities.files import SWEEP_FILES
from studies.quantities.measured import ENERGY_DRIFT_LIMIT
from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from tests.claims.marked import Compared
from tests.claims.rows import Row, at_least, at_most, equal
from tests.service.support.processes import ROOT

FINE, NEAR = 64, 0.03  # cells across the projectile; share of the hole on them


def holes(folder: Path, **changes: Any) -> xr.DataArray:
    document = read_yaml(examples.text("holes"), "holes") | changes
    return xr.load_dataset(whipple.run_sweep(document, folder, keep="numbers") / "cube.nc").hole_diameter


@pytest.mark.claim("mesh-error", "demo-holes", minutes=25.0)
def test_demo__has_the_holes_of_a_finer_grid(tmp_path: Path, compared: Compared) -> None:
    """Holes of the demo are within 3 % of those on 64 cells, at every speed and thickness."""
    coarse, fine = holes(tmp_path / "demo"), holes(tmp_path / "fine", resolution=FINE)
    for hole in (coarse / fine).stack(point=("speed", "plate_thickness")):
        where = f"hole at {float(hole.speed) / 1e3:g} km/s in {1e3 * float(hole.plate_thickness):g} mm"
        compared(at_most(f"{where}: from that on {FINE} cells", limit=NEAR, got=abs(float(hole) - 1.0)))


SHAPES = {"holes": {"speed": 6, "plate_thickness": 2}, "craters": {"speed": 2}}


@pytest.mark.claim("demo", "demo", minutes=2.0)
@pytest.mark.claim("mesh-error", "demo-time", minutes=2.0)
def test_demo__takes_a_minute_and_a_half(tmp_path: Path, compared: Compared) -> None:
    """make demo takes at most 100 s and 150 core-seconds from a fresh clone on two idle cores.

    Neither environment nor kernels are there. Each hole is computed on at least 6 cells through the plate, and the
    energy of each run is kept within 1 %.
    """
    clone = tmp_path / "whipple"
    subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
    environment = {**os.environ, "WHIPPLE_KERNEL_CACHE": f"{tmp_path}/kernels"}
    begin, before = time.perf_counter(), _core_seconds()
    made = subprocess.run(["make", "demo"], cwd=clone, env=environment, capture_output=True, text=True, check=False)
    seconds, cost = time.perf_counter() - begin, _core_seconds() - before
    compared(equal("exit status", expected=0, got=made.returncode))
    for line in made.stdout.splitlines():
        if re.match(r"set up in|wall time|\w+: \d+ succeeded", line):
            compared(Row("stage", "", line, None))
    compared(at_most("the whole (s)", limit=100.0, got=seconds))
    compared(at_most("the whole (core-s)", limit=150.0, got=cost))
    for name in DEMO:
        folder = clone / "demo" / name
        there = {file.name for file in folder.iterdir()} & {*SWEEP_FILES}
        compared(equal(f"{name}: files", expected={*SWEEP_FILES}, got=there))
        cube = whole_cube(folder)
        sizes = {axis: int(cube.sizes[axis]) for axis in SHAPES[name]}
        compared(equal(f"{name}: axes", expected=SHAPES[name], got=sizes))
        drift = float(abs(cube["audit_largest_energy_drift"]).max())
        compared(at_most(f"{name}: largest energy drift of any run", limit=ENERGY_DRIFT_LIMIT, got=drift))
        if "hole_diameter" in cube:
            through = float((cube["cells_per_diameter"] * cube["plate_thickness"]).min() / cube["projectile_diameter"])
            compared(at_least(f"{name}: cells through a plate", limit=6.0, got=through))


def _core_seconds() -> float:
    """Processor time of all that this process has waited for, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
