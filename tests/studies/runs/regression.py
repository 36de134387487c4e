"""Writes the numbers that guard versions: ``python -m tests.studies.runs.regression``, after raising what has to be.

Small runs of every scenario and method that ships, with the identity, sums over the final state and the measurements of
each. The numbers prove nothing about physics; they notice that the same identity gives other numbers, so that no
stored result is taken for one that it is not.
"""

import json
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from solver import PHYSICS_VERSION
from studies.quantities.files import STATE
from studies.runs.execution import execute
from studies.runs.remeasure import load_state
from studies.runs.results import RunResult
from studies.runs.run import Run
from tests import samples
from tests.contracts.test_scenarios import asked

FILE = Path(__file__).with_name("regression.json")
# Another processor rounds sums in another way: code for a generic one (NUMBA_CPU_NAME) moved eight of the cases by up
# to 5e-14 (2026-11).
RELATIVE = 1e-9

SMALL = {"cells_per_diameter": 8.0, "end_time": 8e-6}
LARGE = {"cells_per_diameter": 8.0, "end_time": 2e-5}  # until there is a lip
# The thesis' numerics stay what they are, whatever becomes the default.
THESIS = {"recipe": "thesis", "speed": 4000.0, "cells_per_diameter": 6.0, "end_time": 4e-6}
QUARTER = {
    "geometry": "quarter",
    "cells_per_diameter": 6.0,
    "plate_thickness": 2e-3,
    "plate_radius": 16e-3,
    "end_time": 5e-6,
}
# Each names what it adds; beside it, all is as by default and as small as the contract of scenarios has it.
OWN: dict[str, tuple[str, dict[str, Any]]] = {
    "thin plate": ("thin_plate", {**LARGE, "plate_radius": 24e-3}),
    "thin plate, quarter": ("thin_plate", QUARTER),
    "thin plate, half": ("thin_plate", {**QUARTER, "geometry": "half", "obliquity": 0.5}),
    "thin plate, absorbing edges": ("thin_plate", {**SMALL, "edges": "absorbing"}),
    "thin plate, contact": ("thin_plate", {**SMALL, "contact": "bardenhagen"}),
    "thin plate, thesis": ("thin_plate", THESIS),
    "thin plate, thesis, quarter": ("thin_plate", {**THESIS, "geometry": "quarter"}),
    "thin plate, cubic form": ("thin_plate", {**THESIS, "eos_form": "cubic"}),
    "thin plate, quadratic B-spline": ("thin_plate", {**THESIS, "shape": "quadratic-bspline"}),
    "thin plate, GIMP": ("thin_plate", {**THESIS, "shape": "gimp"}),
    "thin plate, USF": ("thin_plate", {**THESIS, "scheme": "usf"}),
    # It gains or loses half its energy soon after, at one speed or another by one particle.
    "thin plate, USL": ("thin_plate", {**THESIS, "scheme": "usl", "end_time": 2e-6}),
    "thin plate, XPIC": ("thin_plate", {**THESIS, "damping_rate": 1e5, "damping_order": 2}),
    "thin plate, Steinberg-Guinan": (
        "thin_plate",
        {**THESIS, "projectile": "copper-ofhc-steinberg", "target": "copper-ofhc-steinberg"},
    ),
    "thick plate": ("thick_plate", {**LARGE, "target_depth": 24e-3, "target_radius": 24e-3}),
    "thick plate, perfectly plastic": (
        "thick_plate",
        {**THESIS, "projectile": "copper-thesis-plastic", "target": "copper-thesis-plastic"},
    ),
}
# By the file that has their numbers: a feature's is beside its samples.
FILES = {
    FILE: OWN,
    **{
        Path(str(module.__file__)).with_name(FILE.name): module.CASES
        for module in samples.modules()
        if hasattr(module, "CASES")
    },
}
ALL = {case: asked for cases in FILES.values() for case, asked in cases.items()}
CASES = {case: asked for case, asked in ALL.items() if samples.is_there(*asked)}


def stored() -> dict[str, dict[str, Any]]:
    """The cases of all files, each with its numbers; all are of one physics version."""
    cases: dict[str, dict[str, Any]] = {}
    for file in FILES:
        document = json.loads(file.read_text(encoding="utf-8"))
        assert document["physics_version"] == PHYSICS_VERSION, f"{file} is of another physics version"
        cases |= document["cases"]
    return cases


def run_of(case: str) -> Run:
    scenario, changes = CASES[case]
    return asked(scenario, **changes)


def computed(case: str, folder: Path) -> dict[str, Any]:
    """Identity, state and measurements of a case, as the file has them."""
    run = run_of(case)
    result = execute(run, folder, threads=1)
    assert result.state == "succeeded", result.reason
    read = {
        name: {key: getattr(each, key) for key in ("version", "value", "uncertainty", "flags")}
        for name, each in result.measurements.items()
    }
    return {"identity": run.id, "state": dict(_state(result, folder)), "measurements": read}


def _state(result: RunResult, folder: Path) -> Iterator[tuple[str, float]]:
    """Sums over the final state, and what was counted on the way; SI, of the modelled part."""
    snapshot = load_state(folder / STATE)
    particles, mass = snapshot.particles, snapshot.particles.mass
    yield "time", snapshot.time
    yield "steps", result.numbers["steps"]
    yield "tension floors", result.numbers["tension_floors"]
    yield "mass", mass.sum()
    yield "kinetic energy", 0.5 * (mass[:, None] * particles.velocity**2).sum()
    yield "internal energy", (mass * particles.energy).sum()
    yield "moment of the place", (mass[:, None] * particles.position**2).sum()
    yield "pressure", np.sqrt((mass * particles.pressure**2).sum())
    yield "deviator", np.sqrt((mass[:, None] * particles.deviator**2).sum())
    for name in ("plastic_strain", "temperature", "damage"):
        yield name.replace("_", " "), (mass * getattr(particles, name)).sum()


def main() -> None:
    for file, cases in FILES.items():
        lines = []
        for case in cases:
            with tempfile.TemporaryDirectory() as folder:
                content = json.dumps(computed(case, Path(folder)), default=float)
            lines.append(f" {json.dumps(case)}: {content}")
        text = ",\n".join(lines)
        file.write_text(f'{{"physics_version": {PHYSICS_VERSION}, "cases": {{\n{text}\n}}}}\n', encoding="utf-8")
        print(f"{file}: physics version {PHYSICS_VERSION}, {len(cases)} cases")


if __name__ == "__main__":
    main()
