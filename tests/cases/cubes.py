"""Runs and cubes of sweeps that are computed in the process of the test, one run after the other."""

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import xarray as xr

from studies.cubes import cube
from studies.runs.execution import execute
from studies.runs.results import RunResult
from studies.runs.run import resolve
from studies.sweeps.sweep import Sweep


def computed(document: Any, folder: Path) -> xr.Dataset:
    """The cube of a sweep, with a directory for each of its runs in a folder."""
    sweep = Sweep.parse(document)
    results = {point.run.id: execute(point.run, folder / point.run.id, threads=1) for point in sweep.runs()}
    return cube.build(sweep, results)


def result_of(scenario: str, parameters: Mapping[str, Any], *, threads: int = 1) -> RunResult:
    """The result of a run, whose files are gone."""
    with tempfile.TemporaryDirectory() as folder:
        return execute(resolve(scenario, parameters), Path(folder), threads=threads)
