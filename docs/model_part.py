"""The stored sensitivities of holes and craters to strength, failure and equation of state, computed anew.

``python -m docs.model_part`` computes each reference shot with every change of ``studies.sweeps.screening`` and writes
its answers into ``studies/cubes/sensitivities.json``. Half an hour on two cores.
"""

import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from docs.pages import keep
from solver import PHYSICS_VERSION
from studies import materials
from studies.cubes.models import BASE, STORED
from studies.materials import Material
from studies.runs.execution import execute
from studies.runs.results import RunResult
from studies.runs.run import Run, resolve
from studies.sweeps.screening import screens_of

COMMAND = "python -m docs.model_part"
WORKERS = 2
SPHERE = {"projectile_diameter": 8e-3, "projectile_shape": "sphere", "geometry": "axisymmetric", "recipe": "whipple"}
SHOTS: dict[str, dict[str, Any]] = {
    "thin_plate": {**SPHERE, "plate_thickness": 2e-3, "cells_per_diameter": 24.0},
    "thick_plate": {**SPHERE, "edges": "absorbing", "cells_per_diameter": 6.0},
}
SPEEDS = (3e3, 5e3, 7e3)
# Like on like; the first of a family stands for alloys of it that have none.
METALS = (
    *("copper-ofhc", "al-6061-t6", "al-2024-t3", "al-7075-t6", "al-2017-t4", "al-2219-t87", "al-1100-o"),
    *("al-5456-h116", "steel-4340", "steel-304", "armco-iron", "ti-6al-4v", "lead", "tungsten"),
)
DIGITS = 5


def main() -> None:
    """Compute all reference shots, and write what they show."""
    shots = [(scenario, name) for scenario in SHOTS for name in METALS]
    with ProcessPoolExecutor(WORKERS, mp_context=get_context("spawn")) as pool:
        classes = list(pool.map(class_of, *zip(*shots, strict=True)))
    keep(classes, STORED)


def class_of(scenario: str, material: str, speeds: Sequence[float] = SPEEDS) -> dict[str, Any]:
    """The answers of a scenario in a metal: by quantity and change, at each speed."""
    loaded = materials.load(material)
    told: dict[str, dict[str, list[float | None]]] = {}
    for place, speed in enumerate(speeds):
        for change, values in _at(scenario, loaded, speed):
            for quantity, value in values.items():
                column = told.setdefault(quantity, {}).setdefault(change, [None] * len(speeds))
                column[place] = float(f"{value:.{DIGITS}g}")
    return {
        "scenario": scenario,
        "family": loaded.family,
        "alloy": loaded.alloy,
        "material": material,
        "failure": _reference(scenario, loaded, speeds[0]).parameters["failure"],
        "speeds": speeds,
        "parameters": SHOTS[scenario],
        "command": COMMAND,
        "physics": PHYSICS_VERSION,
        "quantities": {quantity: changes for quantity, changes in told.items() if BASE in changes},
    }


def _reference(scenario: str, material: Material, speed: float) -> Run:
    """The shot with the default of everything that is changed."""
    roles = {"projectile": material, "target": material}
    return resolve(scenario, {**SHOTS[scenario], **dict.fromkeys(roles, material.name), "speed": speed}, roles)


def _at(scenario: str, material: Material, speed: float) -> Iterator[tuple[str, dict[str, float]]]:
    """The answers of a shot by each change, the default first."""
    base = _reference(scenario, material, speed)
    yield BASE, _values(base, BASE)
    for screen in screens_of(base):
        if screen.run:
            yield screen.name, _values(screen.run, screen.name)


def _values(run: Run, change: str) -> dict[str, float]:
    """The measured values of a run; it prints what it took."""
    with tempfile.TemporaryDirectory() as folder:
        result: RunResult = execute(run, Path(folder), threads=1)
    print(run.scenario, run.parameters["target"], run.parameters["speed"], change, result.state, flush=True)
    return {name: measured.value for name, measured in result.measurements.items() if measured.value is not None}


if __name__ == "__main__":
    main()
