"""Writes the numbers that guard ``PHYSICS_VERSION``: ``python -m tests.solver.regression``, after raising it.

Small impacts of the shipped scenarios, a fixed number of steps each. The numbers prove nothing about physics; they
notice that the same input gives other numbers, so that no stored result is taken for one that it is not.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np

from solver import PHYSICS_VERSION
from solver.simulation import start
from studies import materials, scenarios
from studies.runs.run import materials_of, resolve

FILE = Path(__file__).with_name("regression.json")
STEPS = 60

# Each names what it adds: geometries, strengths, forms of the equation of state, shapes and schemes. All others of its
# numerics are the thesis', which stay what they are; a default may change without any change of physics.
CASES: dict[str, tuple[str, str, dict[str, Any]]] = {
    "plate, axisymmetric": ("thin_plate", "copper-ofhc", {}),
    "plate, quarter": ("thin_plate", "copper-ofhc", {"geometry": "quarter"}),
    "plate, cubic form": ("thin_plate", "copper-ofhc", {"eos_form": "cubic"}),
    "block, perfectly plastic": ("thick_plate", "copper-thesis-plastic", {}),
    "plate, quadratic B-spline": ("thin_plate", "copper-ofhc", {"shape": "quadratic-bspline"}),
    "plate, GIMP": ("thin_plate", "copper-ofhc", {"shape": "gimp"}),
    "plate, USF": ("thin_plate", "copper-ofhc", {"scheme": "usf"}),
    "plate, USL": ("thin_plate", "copper-ofhc", {"scheme": "usl"}),
    "plate, XPIC": ("thin_plate", "copper-ofhc", {"damping_rate": 1e5, "damping_order": 2}),
    "plate, contact": ("thin_plate", "copper-ofhc", {"contact": "bardenhagen"}),
    "plate, Steinberg-Guinan": ("thin_plate", "copper-ofhc-steinberg", {}),
    "plate, absorbing edges": (
        "thin_plate",
        "copper-ofhc",
        {"edges": "absorbing", "plate_radius": 8e-3},
    ),
}
SIZES: dict[str, dict[str, float]] = {
    "thin_plate": {"plate_thickness": 2e-3, "plate_radius": 16e-3},
    "thick_plate": {"target_depth": 16e-3, "target_radius": 16e-3},
}


def all_numbers() -> dict[str, dict[str, float]]:
    """The numbers of every case."""
    return {case: numbers(case) for case in CASES}


def numbers(case: str) -> dict[str, float]:
    """A handful of sums over the final state of a case (SI)."""
    name, material, changes = CASES[case]
    parameters = {
        "speed": 4000.0,
        "projectile_diameter": 8e-3,
        "cells_per_diameter": 6.0,
        "recipe": "thesis",
        "projectile": material,
        "target": material,
        **SIZES[name],
        **changes,
    }
    copper = materials.load(material)
    run = resolve(name, parameters, {"projectile": copper, "target": copper})
    scenario = scenarios.load(name)
    setting = scenario.build(scenario.parameters(**run.parameters), materials_of(run))
    simulation = start(setting.problem, threads=1)
    for _ in range(STEPS):
        simulation.advance()
    particles, audit = simulation.particles, simulation.audit()
    of_target = particles.mass * (simulation.body == 1)
    return {
        "time": simulation.time,
        "kinetic energy": audit.kinetic,
        "internal energy": audit.internal,
        "momentum of the target": float((of_target[:, None] * particles.velocity).sum()),
        "radial moment": float((particles.mass * particles.position[:, 0]).sum()),
        "pressure": float(np.sqrt((particles.mass * particles.pressure**2).sum())),
        "deviator": float(np.sqrt((particles.mass[:, None] * particles.deviator**2).sum())),
        "plastic strain": float((particles.mass * particles.plastic_strain).sum()),
        "temperature": float((particles.mass * particles.temperature).sum()),
        "tension floors": float(simulation.counters.tension_floors),
    }


def main() -> None:
    """Write the file anew."""
    document = {"physics_version": PHYSICS_VERSION, "cases": all_numbers()}
    FILE.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    print(f"{FILE.name}: physics version {PHYSICS_VERSION}, {len(CASES)} cases of {STEPS} steps")


if __name__ == "__main__":
    main()
