"""Small runs, one of each family, solved once a process."""

import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from studies import materials, scenarios
from studies.runs.execution import execute
from studies.runs.run import Run, resolve
from studies.values.parameters import declared

RUNS: dict[str, dict[str, Any]] = {
    "thin_plate": {
        "speed": 3000.0,
        "projectile_diameter": 8e-3,
        "plate_thickness": 2e-3,
        "plate_radius": 16e-3,
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        "cells_per_diameter": 4.0,
        "end_time": 4e-6,
    },
    # Some of its debris departs.
    "debris_cloud": {
        "speed": 6000.0,
        "projectile_diameter": 8e-3,
        "plate_thickness": 2e-3,
        "plate_radius": 16e-3,
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        "cells_per_diameter": 6.0,
        "downrange": 0.5,
        "end_time": 4e-6,
    },
    "taylor_bar": {"cells_per_diameter": 4.0, "end_time": 20e-6, "reference_length": 16.2e-3, "speed": 400.0},
    "elastic_bar": {},
    "plate_impact": {"cells_per_thickness": 40.0},
}
BROKEN_OFF_AFTER = 23  # steps; between two observations in each of the runs


def asked(scenario: str, **changes: Any) -> Run:
    parameters = {**RUNS[scenario], **changes}
    defaults = declared(scenarios.load(scenario).parameters)
    names = {role: str(parameters.get(role, defaults[role].default)) for role in scenarios.load(scenario).materials}
    return resolve(scenario, parameters, {role: materials.load(name) for role, name in names.items()})


def after(steps: int) -> Callable[[], bool]:
    """Says yes once it has been asked that often."""
    asked_so_far = 0

    def leave() -> bool:
        nonlocal asked_so_far
        asked_so_far += 1
        return asked_so_far >= steps

    return leave


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    """A folder that goes when the process ends."""
    return tempfile.TemporaryDirectory(prefix="whipple-solved-")


@cache
def solved(scenario: str) -> Path:
    """The folder of the solved run of a scenario: read only."""
    folder = Path(_folder().name) / scenario
    execute(asked(scenario), folder, threads=1)
    return folder
