"""Energy that contact takes of the crater of Ma (2005), Table 3.3, and where it goes: plates creep into each other."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from solver.simulation import Simulation, start
from studies import materials
from studies.runs.execution import execute, setting_of
from studies.runs.run import Run, resolve
from studies.scenarios.plate_impact import shocks
from studies.values.results import RunResult
from tests.claims import Row, absolute, at_least, at_most, claim

COPPER = "copper-thesis-plastic"
SPEED, DIAMETER = 6000.0, 4.746e-3  # m/s, m: 0.5 g of copper
CELLS = (1e-3, 0.5e-3, 0.25e-3)  # m
END, TOUCH = 45e-6, 1.3e-6  # s; the shock runs through the sphere before TOUCH
LOST = (0.217, 0.129, 0.080)  # of the energy by END, in docs/theory.md
PRINTED = 0.0005  # half of its last digit
MOST = 0.8  # of the loss, before TOUCH

BLOCK = {"target_depth": 40e-3, "target_radius": 40e-3}  # m
PLATE = 20e-3  # m
CRITERIA = {
    "none": "one field",
    "bardenhagen": "contact",
    "thesis": "the printed criterion",
    "gap": "contact at the gap",
}
# Faces in contact at the gap stand apart by what a compressed particle is thinner than its density says; set when
# -0.05 was known.
STAY = 0.1  # cells


@dataclass(frozen=True)
class Crater:
    """A crater with contact."""

    rise: float  # largest kinetic energy of any step before TOUCH over the initial one, minus 1
    touched: float  # energy that contact removed by TOUCH, of the initial
    removed: float  # and by the end


@cache
def _crater(contact: str, cell: float, end: float) -> Crater:
    parameters = {**_sphere(cell), **BLOCK, "contact": contact}
    simulation = _started("thick_plate", parameters)
    initial = _kinetic(simulation)
    rise = -1.0
    while simulation.time < TOUCH:
        simulation.advance()
        rise = max(rise, _kinetic(simulation) / initial - 1.0)
    touched = simulation.audit().contact_energy
    while simulation.time < end:
        simulation.advance()
    return Crater(rise, touched, simulation.audit().contact_energy)


def _sphere(cell: float) -> dict[str, Any]:
    return {
        "projectile": COPPER,
        "target": COPPER,
        "speed": SPEED,
        "projectile_diameter": DIAMETER,
        "cells_per_diameter": DIAMETER / cell,
        "recipe": "thesis",
        "thermal_softening": False,
        "tension": "unlimited",
    }


def _resolved(scenario: str, parameters: dict[str, Any]) -> Run:
    copper = materials.load(COPPER)
    roles = [role for role, name in parameters.items() if name == COPPER]
    return resolve(scenario, parameters, dict.fromkeys(roles, copper))


def _started(scenario: str, parameters: dict[str, Any]) -> Simulation:
    return start(setting_of(_resolved(scenario, parameters)).problem, threads=1)


def _kinetic(simulation: Simulation) -> float:
    p = simulation.particles
    return 0.5 * float((p.mass * (p.velocity**2).sum(axis=1)).sum())


@claim(
    "contact-touch",
    says="on cells of 1 and 0.5 mm contact raises the kinetic energy of an impact in no step of the first touch",
    quick=True,
)
def contact_touch() -> Iterator[Row]:
    for cell in CELLS[:2]:
        where = f"cells of {1e3 * cell:g} mm: largest rise of the kinetic energy"
        yield at_most(where, limit=0.0, got=_crater("bardenhagen", cell, TOUCH).rise)
        printed = _crater("thesis", cell, TOUCH).rise
        yield Row(f"{where}, the printed criterion", "", printed, None)


@claim(
    "contact-loss",
    says="what contact takes of a crater's energy falls with the cell, and most of it before the shock has run through "
    "the sphere; the printed criterion takes more",
)
def contact_loss() -> Iterator[Row]:
    lost = []
    for cell, expected in zip(CELLS, LOST, strict=True):
        where = f"cells of {1e3 * cell:g} mm"
        crater = _crater("bardenhagen", cell, END)
        lost.append(crater.removed)
        yield absolute(
            f"{where}: energy removed (of the initial)", expected=expected, got=crater.removed, within=PRINTED
        )
        yield at_least(f"{where}: part of it in the first 1.3 us", limit=MOST, got=crater.touched / crater.removed)
        yield at_most(
            f"{where}: of what the printed criterion removes in the first 1.3 us",
            limit=1.0,
            got=crater.touched / _crater("thesis", cell, TOUCH).touched,
        )
    coarse, middle, fine = lost
    order = math.log2((coarse - middle) / (middle - fine))
    yield Row("observed order", "", order, None)


@claim(
    "contact-creep",
    says="plates in contact creep into each other while a shock loads them, by the number of cells that it runs; the "
    "printed criterion lets them creep farther; where the gap is known they stay in place within 0.1 cells",
)
def contact_creep() -> Iterator[Row]:
    faces = {(contact, cells): _overlap(contact, cells) for contact in CRITERIA for cells in (20.0, 40.0)}
    for (contact, cells), (overlap, energy) in faces.items():
        where = f"{CRITERIA[contact]}, a shock through {cells:g} cells"
        yield Row(f"{where}: overlap of the faces (cells)", "", overlap, None)
        yield Row(f"{where}: energy removed (of pressure times a cell)", "", energy, None)
    for cells in (20.0, 40.0):
        none, ours, printed, gap = (faces[contact, cells][0] for contact in CRITERIA)
        yield at_most(f"{cells:g} cells: one field against contact (cells)", limit=ours, got=none)
        where = f"{cells:g} cells: contact against the printed criterion (cells)"
        yield Row(where, f"below {printed:.3g}", ours, ours < printed)
        where = f"{cells:g} cells: contact at the gap (cells)"
        yield absolute(where, expected=0.0, got=gap, within=STAY)
    for contact in ("bardenhagen", "thesis"):
        yield at_least(
            f"{CRITERIA[contact]}, 40 cells: overlap, against that of 20 cells (cells)",
            limit=faces[contact, 20.0][0],
            got=faces[contact, 40.0][0],
        )


@claim(
    "contact-gap-impact",
    says="at 6 km/s contact that knows the gap takes less of the energy than contact that does not; crater and hole "
    "are shown beside",
)
def contact_gap_impact() -> Iterator[Row]:
    for scenario, names in MEASURED.items():
        for cell in CELLS[:2]:
            where = f"{scenario}, cells of {1e3 * cell:g} mm"
            shots = {contact: _shot(scenario, contact, cell) for contact in CRITERIA}
            for name in names:
                for contact, says in CRITERIA.items():
                    value = shots[contact].measurements[name].value
                    got = math.nan if value is None else 1e3 * value
                    yield Row(f"{where}, {says}: {name} (mm)", "", got, None)
            lost = {contact: shots[contact].numbers["contact_energy_fraction"] for contact in CRITERIA}
            yield at_most(
                f"{where}: energy that contact at the gap removed, against contact (of the initial)",
                limit=lost["bardenhagen"],
                got=lost["gap"],
            )


MEASURED = {"thick_plate": ("crater_depth", "crater_diameter"), "thin_plate": ("hole_diameter",)}


def _shot(scenario: str, contact: str, cell: float) -> RunResult:
    """The sphere of the crater on its block, or on a plate of a quarter of its diameter."""
    parameters = {
        **_sphere(cell),
        "contact": contact,
        **(BLOCK if scenario == "thick_plate" else {"plate_thickness": 0.25 * DIAMETER}),
    }
    with TemporaryDirectory() as folder:
        return execute(_resolved(scenario, parameters), Path(folder), threads=1)


def _overlap(contact: str, cells: float) -> tuple[float, float]:
    """Overlap of the faces in cells, their outermost layers as thick as the Hugoniot says, and what contact took."""
    parameters = {
        "flyer": COPPER,
        "target": COPPER,
        "speed": SPEED,
        "flyer_thickness": PLATE,
        "cells_per_thickness": cells,
        "cells_across": 2,
        "geometry": "quarter",
        "recipe": "thesis",
        "contact": contact,
    }
    simulation = _started("plate_impact", parameters)
    initial = _kinetic(simulation)
    while simulation.time < simulation.problem.end_time:
        simulation.advance()
    copper = materials.load(COPPER)
    state = shocks(copper, copper, SPEED)
    flyer, target = (simulation.particles.position[simulation.body == body, 2] for body in (0, 1))
    spacing = simulation.problem.bodies[0].spacing[2]
    layer = spacing * copper.density / state.densities[0]
    cell = simulation.problem.geometry.spacing
    overlap = (float(np.max(flyer)) - float(np.min(target)) + layer) / cell
    section = (2.0 * cell) ** 2
    taken = simulation.audit().contact_energy * initial
    return overlap, taken / (section * state.pressure * cell)
