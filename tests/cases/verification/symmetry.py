"""Impacts that are moved, mirrored, cut and scaled: what the equations do not tell apart, the solver does not either.

A mirror image and a shift by whole cells change nothing but round-off, and so does a flight by whole cells in every
step; a quarter model is the quarter of the whole plate, and has its hole. Without a rate in the material, 2^n times the
problem gives the same answer, bit for bit: every length and time is multiplied by a power of two, which no
floating-point operation rounds, so that a constant length or time hidden in the solver would show.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from solver.problem import Problem
from solver.simulation import simulate
from solver.state import Particles, Snapshot
from studies import measurements
from studies.measurements.impact.view import view
from studies.quantities.numerical_defaults import Recipe
from tests.cases.verification import case
from tests.cases.verification.setups.impacts import (
    ROUND_OFF,
    SMALL,
    STEPS,
    advanced,
    boosted,
    differing_values,
    enlarged,
    image,
    impact_setting,
    largest_difference,
    mirrored,
    ordered,
    scaled,
    shifted,
    unfolded,
)
from tests.claims.rows import Row, absolute, at_most, reported

SPEED = float(SMALL["speed"])

OBLIQUITY = 0.5  # rad
# Of a whole plate, and the axes across which they are images of the first.
QUARTERS = {"the first": (), "the image in x": (0,), "that in y": (1,), "that in both": (0, 1)}

SHIFT = 7  # cells
# Of a cell in a step of the quickest signal: a fixed step, so that the flight can be a whole cell in each.
COURANT = 0.1

POWERS = (-4, 7)
SCALED_STEPS = {"axisymmetric": 400, "quarter": 60}

END_TIME = 25e-6  # s, of a hole
# Half a cell is what a user may count on. Faces of symmetry that turn no force round shift the hole by half of that: a
# twentieth of a cell sees them.
WITHIN = 0.05
QUANTITIES = ("hole_diameter", "hole_diameter_areal")


@case("mirror", says="mirror image and quarter against whole: round-off for 50 steps", source="symmetry")
def _mirror(recipe: Recipe) -> Iterator[Row]:
    oblique = impact_setting(recipe, geometry="half", obliquity=OBLIQUITY).problem
    turned = image(ordered(advanced(mirrored(oblique)).particles))
    straight = ordered(advanced(oblique).particles)
    yield at_most(
        f"oblique impact and its mirror image, {STEPS} steps: largest difference",
        limit=ROUND_OFF,
        got=largest_difference(straight, turned, spacing=oblique.geometry.spacing, speed=SPEED),
    )
    quarter = impact_setting(recipe, geometry="quarter").problem
    part = ordered(advanced(quarter).particles)
    whole = ordered(advanced(unfolded(unfolded(quarter, 0), 1)).particles)
    for name, other in zip(QUARTERS, _quarters(whole, quarter), strict=True):
        yield at_most(
            f"quarter against {name} of the whole, {STEPS} steps: largest difference",
            limit=ROUND_OFF,
            got=largest_difference(part, other, spacing=quarter.geometry.spacing, speed=SPEED),
        )


def _quarters(whole: Particles, quarter: Problem) -> Iterator[Particles]:
    """The four quarters of the unfolded whole, each mirrored onto the first.

    Body by body stand the originals, their images in x, and the images of both in y.
    """
    sizes = np.array([body.mass.size for body in quarter.bodies])
    begins = 4 * (np.cumsum(sizes) - sizes)
    for number, axes in enumerate(QUARTERS.values()):
        index = np.concatenate(
            [begin + number * size + np.arange(size) for begin, size in zip(begins, sizes, strict=True)]
        )
        some = type(whole)(*(field[index] for field in whole))
        for axis in axes:
            some = image(some, axis)
        yield some


@case("grid-shift", says="a shift by whole cells changes round-off only", source="the grid has no preferred cell")
def _grid_shift(recipe: Recipe) -> Iterator[Row]:
    for geometry, axis in (("axisymmetric", 1), ("quarter", 2)):
        # A held rim would not fly.
        setting = impact_setting(recipe, geometry=geometry, edges="free")
        spacing = setting.problem.geometry.spacing
        along = (np.arange(3) == axis).astype(np.int64)
        room = enlarged(setting.problem, 0 * along, (SHIFT + STEPS) * along)
        problem = replace(room, fixed_dt=COURANT * spacing / SPEED)
        here = ordered(advanced(problem).particles)

        offset = SHIFT * spacing * along
        there = ordered(advanced(shifted(problem, offset)).particles)
        moved = there._replace(position=there.position - offset)
        yield at_most(
            f"{geometry}: {SHIFT} cells farther, {STEPS} steps: largest difference",
            limit=ROUND_OFF,
            got=largest_difference(here, moved, spacing=spacing, speed=SPEED),
        )

        flight = SPEED / COURANT * along  # one cell a step
        flown = advanced(boosted(problem, flight))
        after = ordered(flown.particles)
        still = after._replace(position=after.position - flight * flown.time, velocity=after.velocity - flight)
        yield at_most(
            f"{geometry}: one cell farther in every step, {STEPS} steps: largest difference",
            limit=ROUND_OFF,
            got=largest_difference(here, still, spacing=spacing, speed=float(flight.max())),
        )


@case(
    "similarity",
    says="geometric similarity holds bit for bit",
    source="dimensional analysis; multiplication by 2^n is exact (IEEE 754)",
)
def _similarity(recipe: Recipe) -> Iterator[Row]:
    for geometry, steps in SCALED_STEPS.items():
        problem = impact_setting(recipe, geometry=geometry).problem
        small = advanced(problem, steps)
        p = ordered(small.particles)
        for power in POWERS:
            factor = 2.0**power
            large = advanced(scaled(problem, factor), steps)
            expected = p._replace(position=p.position * factor, mass=p.mass * factor**3)
            bits = differing_values(expected, ordered(large.particles)) + (large.time != small.time * factor)
            yield at_most(
                f"{geometry}, {SPEED / 1e3:g} km/s, {steps} steps, 2^{power} times as large: values that differ",
                limit=0,
                got=bits,
            )


@case(
    "quarter-hole",
    says="the hole of a quarter model is that of the whole plate within a twentieth of a cell",
    source="symmetry; round-off grows in a flow that breaks up, a hole must not",
)
def _quarter_hole(recipe: Recipe) -> Iterator[Row]:
    quarter = impact_setting(recipe, geometry="quarter", material="copper-ofhc", end_time=END_TIME, plate_radius=20e-3)
    whole = unfolded(unfolded(quarter.problem, 0), 1)
    cell = quarter.problem.geometry.spacing
    views = {
        "quarter": view(quarter, simulate(quarter.problem).snapshot),
        "whole": view(quarter, _folded(simulate(whole).snapshot)),
    }
    for quantity in QUANTITIES:
        read = {name: measurements.load(quantity).read(state).value for name, state in views.items()}
        yield absolute(
            f"{quantity}, {SPEED / 1e3:g} km/s, {SMALL['cells_per_diameter']:g} cells per diameter: "
            "quarter against whole (cells)",
            expected=read["whole"] / cell,
            got=read["quarter"] / cell,
            within=WITHIN if quantity == QUANTITIES[0] else None,
        )
    yield reported("hole of the whole plate (mm)", 1e3 * measurements.load(QUANTITIES[0]).read(views["whole"]).value)


def _folded(snapshot: Snapshot) -> Snapshot:
    """The four quarters of a plate on top of one another, each with a quarter of its mass."""
    p = snapshot.particles
    position = p.position.copy()
    position[:, :2] = np.abs(position[:, :2])
    return snapshot._replace(particles=p._replace(position=position, mass=0.25 * p.mass))


CASE = (_mirror, _grid_shift, _similarity, _quarter_hole)
