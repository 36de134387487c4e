"""Energy that contact takes of the crater of Ma (2005), Table 3.3, and where it goes: plates creep into each other."""

import math
from collections.abc import Callable
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solver.audit import totals
from solver.simulation import start
from studies import materials
from studies.plate_impacts.scenario import shocks
from studies.runs.execution import execute
from studies.runs.run import Run, resolve
from studies.runs.stages import setting_of
from tests.claims.rows import Row, absolute, at_least, at_most

COPPER = "copper-thesis-plastic"
SPEED, DIAMETER = 6000.0, 4.746e-3  # m/s, m: 0.5 g of copper
CELLS = (1e-3, 0.5e-3, 0.25e-3)  # m
END, TOUCH = 45e-6, 1.3e-6  # s; the shock runs through the sphere before TOUCH
LOST = (0.217, 0.129, 0.080)  # of the energy by END, in docs/theory.md
PRINTED = 0.0005  # half of its last digit
MOST = 0.8  # of the loss, before TOUCH

PLATE = 20e-3  # m
# Of the sphere: its block, or a plate of a quarter of its diameter; and what is measured.
TARGETS: dict[str, dict[str, Any]] = {
    "thick_plate": {"target_depth": 40e-3, "target_radius": 40e-3},
    "thin_plate": {"plate_thickness": 0.25 * DIAMETER},
}
MEASURED = {"thick_plate": ("crater_depth", "crater_diameter"), "thin_plate": ("hole_diameter",)}
CRITERIA = {
    "none": "one field",
    "bardenhagen": "contact",
    "thesis": "the printed criterion",
    "gap": "contact at the gap",
}
# Faces in contact at the gap stand apart by what a compressed particle is thinner than its density says; set when
# -0.05 was known.
STAY = 0.1  # cells


def sphere(scenario: str, contact: str, cell: float) -> Run:
    parameters = {
        "projectile": COPPER,
        "target": COPPER,
        "speed": SPEED,
        "projectile_diameter": DIAMETER,
        "cells_per_diameter": DIAMETER / cell,
        "recipe": "thesis",
        "thermal_softening": False,
        "tension": "unlimited",
        "contact": contact,
        **TARGETS[scenario],
    }
    return resolve(scenario, parameters)


@cache
def crater(contact: str, cell: float, end: float = TOUCH) -> tuple[float, float]:
    """Energy that contact removed by TOUCH and by the end, of the initial one."""
    simulation = start(setting_of(sphere("thick_plate", contact, cell)).problem, threads=1)
    while simulation.time < TOUCH:
        simulation.advance()
    touched = simulation.audit().contact_energy
    while simulation.time < end:
        simulation.advance()
    return touched, simulation.audit().contact_energy


@pytest.mark.claim("cases", "contact-loss", minutes=10.0)
def test_contact__takes_less_on_finer_cells(compared: Callable[[Row], None]) -> None:
    """What contact takes of a crater's energy falls with the cell; the printed criterion takes more.

    Most is taken before the shock has run through the sphere.
    """
    lost = []
    for cell, expected in zip(CELLS, LOST, strict=True):
        where = f"cells of {1e3 * cell:g} mm"
        touched, removed = crater("bardenhagen", cell, END)
        lost.append(removed)
        compared(absolute(f"{where}: energy removed (of the initial)", expected=expected, got=removed, within=PRINTED))
        compared(at_least(f"{where}: part of it in the first 1.3 us", limit=MOST, got=touched / removed))
        claim = f"{where}: of what the printed criterion removes in the first 1.3 us"
        compared(at_most(claim, limit=1.0, got=touched / crater("thesis", cell)[0]))
    coarse, middle, fine = lost
    compared(Row("observed order", "", math.log2((coarse - middle) / (middle - fine)), None))


@pytest.mark.claim("cases", "contact-creep", minutes=1.0)
def test_plates__creep_by_cells_and_stay_in_place_at_the_gap(compared: Callable[[Row], None]) -> None:
    """Plates in contact creep into each other by the cells that a shock runs, and stay within 0.1 cells at the gap.

    The printed criterion lets them creep farther.
    """
    faces = {(contact, cells): overlap(contact, cells) for contact, cells in product(CRITERIA, (20.0, 40.0))}
    for (contact, cells), (cells_over, energy) in faces.items():
        where = f"{CRITERIA[contact]}, a shock through {cells:g} cells"
        compared(Row(f"{where}: overlap of the faces (cells)", "", cells_over, None))
        compared(Row(f"{where}: energy removed (of pressure times a cell)", "", energy, None))
    for cells in (20.0, 40.0):
        none, ours, printed, gap = (faces[contact, cells][0] for contact in CRITERIA)
        where = f"{cells:g} cells"
        compared(at_most(f"{where}: one field against contact (cells)", limit=ours, got=none))
        claim = f"{where}: contact against the printed criterion (cells)"
        compared(Row(claim, f"below {printed:.3g}", ours, ours < printed))
        compared(absolute(f"{where}: contact at the gap (cells)", expected=0.0, got=gap, within=STAY))
    for contact in ("bardenhagen", "thesis"):
        claim = f"{CRITERIA[contact]}, 40 cells: overlap, against that of 20 cells (cells)"
        compared(at_least(claim, limit=faces[contact, 20.0][0], got=faces[contact, 40.0][0]))


def overlap(contact: str, cells: float) -> tuple[float, float]:
    """Overlap of the faces in cells, their outermost layers as thick as the Hugoniot says, and what contact took."""
    parameters: dict[str, str | float] = {
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
    simulation = start(setting_of(resolve("plate_impact", parameters)).problem, threads=1)
    initial = totals(simulation.particles).kinetic
    while simulation.time < simulation.problem.end_time:
        simulation.advance()
    state = shocks(materials.load(COPPER), materials.load(COPPER), SPEED)
    flyer, target = (simulation.particles.position[simulation.body == body, 2] for body in (0, 1))
    layer = simulation.problem.bodies[0].spacing[2] * (1.0 - 0.5 * SPEED / state.speeds[0])  # rho0 / rho
    cell = simulation.problem.geometry.spacing
    taken = simulation.audit().contact_energy * initial
    return (float(np.max(flyer)) - float(np.min(target)) + layer) / cell, taken / (4.0 * cell**3 * state.pressure)


@pytest.mark.claim("cases", "contact-gap-impact", minutes=5.0)
def test_contact__at_the_gap_takes_less_energy(compared: Callable[[Row], None], tmp_path: Path) -> None:
    """At 6 km/s contact that knows the gap takes less of the energy than contact that does not.

    Crater and hole are shown beside.
    """
    for scenario, cell in product(MEASURED, CELLS[:2]):
        where = f"{scenario}, cells of {1e3 * cell:g} mm"
        runs = {contact: sphere(scenario, contact, cell) for contact in CRITERIA}
        shots = {contact: execute(run, tmp_path / run.id, threads=1) for contact, run in runs.items()}
        for name, (contact, says) in product(MEASURED[scenario], CRITERIA.items()):
            value = shots[contact].measurements[name].value
            compared(Row(f"{where}, {says}: {name} (mm)", "", math.nan if value is None else 1e3 * value, None))
        lost = {contact: shot.numbers["contact_energy_fraction"] for contact, shot in shots.items()}
        claim = f"{where}: energy that contact at the gap removed, against contact (of the initial)"
        compared(at_most(claim, limit=lost["bardenhagen"], got=lost["gap"]))
