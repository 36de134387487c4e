"""Cubes of real sweeps whose runs have invented sizes: a formula of their shots."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import xarray as xr

from studies import laws
from studies.cubes import cube
from studies.laws import Shot
from studies.runs.results import RunResult
from studies.sweeps.sweep import Sweep
from tests.studies.support import fakes

BLOCK = {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "5 mm"}
CRATERS: Mapping[str, Any] = {
    "name": "made-up",
    "scenario": "thick_plate",
    "fixed": BLOCK,
    "axes": {"speed": [f"{speed} km/s" for speed in range(3, 9)]},
    "resolution": 16,
}
HOLES: Mapping[str, Any] = {
    **CRATERS,
    "scenario": "thin_plate",
    "axes": {**CRATERS["axes"], "plate_thickness": ["1 mm", "2 mm", "3 mm"]},
}


def sized_cube(
    document: Mapping[str, Any],
    size: Callable[[Shot], float],
    quantity: str,
    flag: Callable[[Shot], str] = lambda shot: "",
) -> xr.Dataset:
    """The cube of a sweep in which a quantity is a function of the shot, m, and so is a flag of it."""
    sweep = Sweep.parse(document)
    results = {}
    for point in sweep.runs():
        shot = laws.shot_from(point.run.parameters, point.run.materials)
        measured = replace(fakes.measured(size(shot)), flags=tuple(filter(None, [flag(shot)])))
        results[point.run.id] = RunResult(point.run.id, "succeeded", measurements={quantity: measured})
    return cube.build(sweep, results)
