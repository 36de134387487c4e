"""The main job as a new user runs it: ``make demo`` in a fresh clone, without an environment and without kernels."""

import os
import re
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import xarray as xr

from service.cli.commands.computing import DEMO
from tests.benchmarks.baseline import ROOT
from tests.claims import Row, at_least, at_most, claim

LIMIT = 300.0  # s on two idle cores, packages in pip's cache
FINEST, THROUGH_PLATE = (24.0, 3.0)  # cells per projectile diameter of the finest grid; through a plate on the coarsest


@claim(
    "demo-time",
    says="make demo takes less than five minutes from a fresh clone on two idle cores; each hole is computed on 16 and "
    "24 cells per diameter or finer, and on at least 3 through the plate",
)
def demo_time() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as folder:
        clone = Path(folder) / "whipple"
        subprocess.run(["git", "clone", "--quiet", str(ROOT), str(clone)], check=True)
        begin = time.perf_counter()
        made = subprocess.run(
            ["make", "demo"],
            cwd=clone,
            env={**os.environ, "WHIPPLE_KERNEL_CACHE": f"{folder}/kernels"},
            capture_output=True,
            text=True,
            check=False,
        )
        seconds = time.perf_counter() - begin
        yield Row("exit status", 0, made.returncode, made.returncode == 0)
        for line in made.stdout.splitlines():
            if re.match(r"set up in|kernels:|wall time|\w+: \d+ succeeded", line):
                yield Row("stage", "", line, None)
        yield at_most("the whole (s)", limit=LIMIT, got=seconds)
        for name in DEMO:
            with xr.open_dataset(clone / "demo" / name / "cube.nc") as cube:
                yield from _grids(name, cube)


def _grids(name: str, cube: xr.Dataset) -> Iterator[Row]:
    if "hole_diameter" not in cube:
        return
    cells = cube["cells_per_diameter"]
    grids = sorted({float(value) for value in cells.to_numpy().ravel()})
    yield at_least(f"{name}: grids of at least 16 cells per diameter", limit=2, got=len(grids))
    yield at_least(f"{name}: cells per diameter, coarsest", limit=16.0, got=grids[0])
    yield at_least(f"{name}: cells per diameter, finest", limit=FINEST, got=grids[-1])
    through = cells * cube["plate_thickness"] / cube["projectile_diameter"]
    yield at_least(f"{name}: cells through a plate", limit=THROUGH_PLATE, got=float(through.min()))
