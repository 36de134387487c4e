"""The stored sensitivities of holes and craters to strength, failure and equation of state, computed anew.

``python -m docs.model_part`` computes each reference shot with every change of ``studies.sweeps.screening`` and writes
``studies/cubes/sensitivities.json``: the larger of two speeds for each contribution. Some minutes on two cores.
"""

import json
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from solver import PHYSICS_VERSION
from studies import materials
from studies.cubes.models import STORED
from studies.runs.execution import execute
from studies.runs.results import RunResult
from studies.runs.run import Run, resolve
from studies.sweeps.screening import contributions_of, screens_of

COMMAND = "python -m docs.model_part"
WORKERS = 2
CELLS = 24.0
SPHERE = {
    "projectile_diameter": 8e-3,
    "projectile_shape": "sphere",
    "geometry": "axisymmetric",
    "cells_per_diameter": CELLS,
    "recipe": "whipple",
}
SHOTS: dict[str, dict[str, Any]] = {
    "thin_plate": {**SPHERE, "plate_thickness": 2e-3},
    "thick_plate": {**SPHERE, "edges": "absorbing", "cells_per_diameter": 8.0},
}
SPEEDS = (4e3, 6e3)
MATERIALS = ("copper-ofhc", "al-6061-t6")


def main() -> None:
    """Compute all reference shots, and write what they show."""
    shots = [(scenario, name) for scenario in SHOTS for name in MATERIALS]
    with ProcessPoolExecutor(WORKERS, mp_context=get_context("spawn")) as pool:
        classes = list(pool.map(_class, *zip(*shots, strict=True)))
    STORED.write_text(json.dumps(classes, indent=1) + "\n", encoding="utf-8")


def _class(scenario: str, material: str) -> dict[str, Any]:
    """The sensitivities of a scenario in a class of materials."""
    told: dict[str, dict[str, float]] = {}
    for speed in SPEEDS:
        for quantity, contributions in _at(scenario, material, speed):
            largest = told.setdefault(quantity, {})
            for name, share in contributions.items():
                largest[name] = max(round(share, 4), largest.get(name, 0.0))
    return {
        "scenario": scenario,
        "family": materials.load(material).family,
        "material": material,
        "speeds": SPEEDS,
        "parameters": SHOTS[scenario],
        "command": COMMAND,
        "physics": PHYSICS_VERSION,
        "quantities": told,
    }


def _at(scenario: str, material: str, speed: float) -> Iterator[tuple[str, dict[str, float]]]:
    """The contributions to each quantity of a shot."""
    loaded = materials.load(material)
    roles = {"projectile": loaded, "target": loaded}
    names = dict.fromkeys(roles, material)
    base_run = resolve(scenario, {**SHOTS[scenario], **names, "speed": speed}, roles)
    base = _values(base_run)
    changed = {each.name: _values(each.run) for each in screens_of(base_run) if each.run}
    for quantity, value in base.items():
        answers = {name: values[quantity] for name, values in changed.items() if quantity in values}
        if value:
            yield quantity, contributions_of(value, answers)


def _values(run: Run) -> dict[str, float]:
    """The measured values of a run; it prints what it took."""
    with tempfile.TemporaryDirectory() as folder:
        result: RunResult = execute(run, Path(folder), threads=1)
    print(run.scenario, run.parameters["target"], run.parameters["speed"], result.state, flush=True)
    return {name: measured.value for name, measured in result.measurements.items() if measured.value is not None}


if __name__ == "__main__":
    main()
