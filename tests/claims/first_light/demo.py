"""The main job: ``whipple demo`` on an embedded engine, from a cold kernel cache."""

import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import xarray as xr

from studies.values.results import ENERGY_DRIFT_LIMIT
from tests.claims import Row, at_most, claim

FILES = {"cube.nc", "runs.csv", "report.html", "report.json"}
SHAPES = {
    "holes": {"speed": 6},
    "aluminium": {"speed": 3, "plate_thickness": 2},
    "sphere": {"speed": 1},
    "craters": {"speed": 4},
}


@claim("demo", says="the demo computes holes and craters, cubes and reports, with energy kept within 1 %")
def demo() -> Iterator[Row]:
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "demo"
        environment = {**os.environ, "WHIPPLE_KERNEL_CACHE": str(Path(folder) / "kernels")}
        ran = subprocess.run(
            [sys.executable, "-m", "service", "demo", "--out", str(out)],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        yield Row("exit status of the demo", 0, ran.returncode, ran.returncode == 0)
        times = re.search(r"wall time: ([\d.]+) s", ran.stdout)
        yield Row("cold wall time (s)", "printed", times.groups() if times else "", bool(times))
        for name, shape in SHAPES.items():
            there = {file.name for file in (out / name).iterdir()}
            yield Row(f"files of {name}", sorted(FILES), sorted(FILES & there), there >= FILES)
            yield from _cube(name, shape, out / name / "cube.nc")


def _cube(name: str, shape: dict[str, int], path: Path) -> Iterator[Row]:
    with xr.open_dataset(path) as cube:
        sizes = {axis: int(cube.sizes[axis]) for axis in shape}
        yield Row(f"axes of {name}", shape, sizes, sizes == shape)
        drift = np.abs(cube["audit_largest_energy_drift"].to_numpy())
        yield at_most(f"largest energy drift of any run of {name}", limit=ENERGY_DRIFT_LIMIT, got=float(drift.max()))
        for quantity in ("hole_diameter", "crater_depth", "crater_diameter"):
            if quantity in cube:
                values = np.round(cube[quantity].to_numpy() * 1e3, 2).tolist()
                yield Row(f"{quantity} by {', '.join(map(str, cube[quantity].dims))} (mm)", "", values, None)
