"""Cubes of sweeps that are computed in the process of the test, one run after the other."""

from pathlib import Path
from typing import Any

import xarray as xr

from studies.cubes import cube
from studies.runs.execution import execute
from studies.sweeps.sweep import Sweep


def computed(document: Any, folder: Path) -> xr.Dataset:
    """The cube of a sweep, with a directory for each of its runs in a folder."""
    sweep = Sweep.parse(document)
    results = {point.run.id: execute(point.run, folder / point.run.id, threads=1) for point in sweep.runs()}
    return cube.build(sweep, results)
