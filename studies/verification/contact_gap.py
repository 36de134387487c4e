"""Bodies with fields of their own whose distance is known at the nodes: they touch when their surfaces meet."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from solver.problem import Contact, Criterion, Problem, StepRule
from solver.simulation import start
from studies.values.recipes import Recipe
from studies.verification import Case, Row, absolute, at_least, at_most, relative, reported
from studies.verification._column import Stretch, column
from studies.verification._impacts import impact_setting
from studies.verification._matter import elastic
from studies.verification.bar_contact import CONTACT_TIME, REBOUND
from studies.verification.contact import (
    BAR,
    CELLS,
    FRICTION,
    ROUND_OFF,
    SLIDING_GATED,
    SPACING,
    SPEEDS,
    collided,
    impact,
    sliding,
)

GAP = Contact(0.0, Criterion.GAP)
# Faces: distances and places on the grid that are no whole cells.
GAP_CELLS, SHIFTS = 1.37, (0.0, 0.31, 0.5, 0.77)
FACE_SPEEDS = (60.0, 600.0, 6000.0)  # m/s
LENGTH = 8  # of the blocks, cells
TRAVEL = 0.02  # cells that a block flies in a step: the first impulse is known to as much
# Gates, set before any figure. A sphere ends where its particles do, which fill it to half of their size.
FACES, OF_A_PARTICLE = 0.1, 0.5  # cells; particles
SPHERE_CELLS = {"axisymmetric": 16.0, "quarter": 8.0}  # per diameter
SPHERE_SPEEDS = (600.0, 6000.0)  # m/s
# Linear functions change forces by jumps: that contact gives no more than it took is reported of them.
SMOOTH = ("gimp", "quadratic-bspline")


def _run(recipe: Recipe) -> Iterator[Row]:
    shapes = dict.fromkeys((recipe.shape, "gimp", "linear"))
    for shape in shapes:
        chosen = replace(recipe, shape=shape)
        for speed in FACE_SPEEDS:
            off = [_faces(chosen, speed, shift, GAP) for shift in SHIFTS]
            yield absolute(
                f"{shape}, {speed:g} m/s: distance of the faces at the first impulse, the farthest of {len(SHIFTS)} "
                "grids (cells)",
                expected=0.0,
                got=max(off, key=abs),
                within=FACES,
            )
        early = _faces(chosen, FACE_SPEEDS[0], SHIFTS[1], Contact(0.0))
        yield reported(f"{shape}: the same where the gap is not known (cells)", early)
    for geometry in SPHERE_CELLS:
        for speed in SPHERE_SPEEDS:
            yield from _sphere(replace(recipe, shape="gimp"), geometry, speed)
    for shape in shapes:
        for speed in SPEEDS:
            yield from _bars(replace(recipe, shape=shape), speed)
    for shape in SLIDING_GATED:
        for friction in (0.0, FRICTION):
            yield from sliding(GAP._replace(friction=friction), replace(recipe, shape=shape))
    for scenario in ("thin_plate", "thick_plate"):
        yield from impact(scenario, "gap", recipe)


def _faces(recipe: Recipe, speed: float, shift: float, contact: Contact) -> float:
    """Distance of the faces of two blocks in free flight when the first impulse has acted, cells."""
    begin, length, gap = (cells * SPACING for cells in (3.0 + shift, LENGTH, GAP_CELLS))
    matter = elastic(BAR)
    problem = column(
        [
            Stretch("first", matter, BAR.density, begin, begin + length, speed),
            Stretch("second", matter, BAR.density, begin + length + gap, begin + 2.0 * length + gap),
        ],
        recipe,
        cells=2 * LENGTH + 10,
        spacing=SPACING,
        end_time=2.0 * gap / speed,
        contact=contact,
        travel=TRAVEL,
        step_rule=StepRule.ACOUSTIC,
    )
    return (gap - speed * _first_impulse(problem)) / SPACING


def _first_impulse(problem: Problem) -> float:
    """Time after the first step in which the second body has got momentum, s."""
    simulation = start(problem, threads=1)
    while simulation.time < problem.end_time:
        simulation.advance()
        if np.abs(simulation.particles.velocity[simulation.body == 1]).max() > 0.0:
            return simulation.time
    return math.nan


def _sphere(recipe: Recipe, geometry: str, speed: float) -> Iterator[Row]:
    """A sphere flies towards a plate, from a distance that is no whole cell."""
    setting = impact_setting(
        recipe,
        name="thin_plate",
        geometry=geometry,
        material="copper-ofhc",
        contact="gap",
        speed=speed,
        cells_per_diameter=SPHERE_CELLS[geometry],
        travel=TRAVEL,
    )
    problem, cell = setting.problem, setting.problem.geometry.spacing
    axis = 1 if geometry == "axisymmetric" else 2
    sphere, plate = problem.bodies
    face = plate.position[:, axis].min() - 0.5 * plate.spacing[axis]
    middle = np.average(sphere.position[:, axis], weights=sphere.mass)
    away = face - GAP_CELLS * cell - (middle + 0.5 * setting.projectile_diameter)
    moved = sphere.position + away * np.eye(3)[axis]
    edge = moved[:, axis].max() + 0.5 * sphere.spacing[axis]
    problem = replace(problem, bodies=(replace(sphere, position=moved), plate))
    flown = speed * _first_impulse(problem) / cell
    where = f"sphere of {SPHERE_CELLS[geometry]:g} cells on a plate, {geometry}, {speed:g} m/s"
    yield absolute(
        f"{where}: distance of the surfaces at the first impulse (cells)",
        expected=0.0,
        got=GAP_CELLS - flown,
        within=OF_A_PARTICLE / recipe.particles_per_cell + TRAVEL,
    )
    yield reported(
        f"{where}: distance of the plate from its outermost particles' ends (cells)", float(face - edge) / cell - flown
    )


def _bars(recipe: Recipe, speed: float) -> Iterator[Row]:
    """A bar hits an equal one at rest: it stops, and the other takes its velocity after 2 L / c."""
    history = collided(speed, recipe, GAP)
    total = BAR.density * CELLS * SPACING**3 * speed
    where, smooth = f"bars, {recipe.shape}, {speed:g} m/s", recipe.shape in SMOOTH
    yield relative(
        f"{where}: time for which the push is above rho c v / 4 (of 2 L / c)",
        expected=1.0,
        got=history.pushed(speed),
        within=CONTACT_TIME if smooth else None,
    )
    share = float(history.second[-1]) / total
    parted = at_least(f"{where}: momentum of the bar that was hit (of all; perfect: 1)", limit=REBOUND, got=share)
    yield parted if smooth else parted.ungated(REBOUND)
    yield at_most(
        f"{where}: kinetic energy above the initial one, ever (of it)",
        limit=ROUND_OFF,
        got=float(history.kinetic.max() / history.kinetic[0] - 1.0),
    )
    given = at_most(
        f"{where}: energy that contact gave beyond what it had taken, ever (of the initial)",
        limit=ROUND_OFF,
        got=-float(history.taken.min()),
    )
    yield given if smooth else given.ungated(ROUND_OFF)
    audit = history.simulation.audit()
    yield at_most(f"{where}: error of the momentum", limit=ROUND_OFF, got=audit.momentum_error)
    yield reported(f"{where}: energy accounted to contact (of the initial)", audit.contact_energy)
    other = collided(speed, recipe, Contact(0.0))
    for says, value in (
        ("time of the push (of 2 L / c)", other.pushed(speed)),
        ("momentum of the bar that was hit", float(other.second[-1]) / total),
        ("energy accounted to contact", other.simulation.audit().contact_energy),
    ):
        yield reported(f"{where}, where the gap is not known: {says}", value)


CASE = Case(
    name="contact-gap",
    says="bodies whose distance is known touch within 0.1 cells of where their faces meet, spheres within half a "
    "particle; elastic bars part after 2 L / c within 3 % with 0.93 of the momentum, and contact creates no energy",
    source="free flight; d'Alembert for the bars; Coulomb; Nairn, Hammerquist and Smith (2020) for the criterion",
    run=_run,
    quick=False,
)
