"""Geometric similarity: without a rate in the material, 2^n times the problem gives the same answer, bit for bit.

Every length and time is multiplied by a power of two, which no floating-point operation rounds; a constant length or
time hidden in the solver would show.
"""

from collections.abc import Iterator

from solver.state import Particles
from studies.values.recipes import Recipe
from studies.verification import Case, Row, at_most
from studies.verification._impacts import SMALL, advanced, differing_values, impact_setting, ordered, scaled

POWERS = (-4, 7)
STEPS = {"axisymmetric": 400, "quarter": 60}


def _run(recipe: Recipe) -> Iterator[Row]:
    for geometry, steps in STEPS.items():
        problem = impact_setting(recipe, geometry=geometry).problem
        small = advanced(problem, steps)
        for power in POWERS:
            factor = 2.0**power
            large = advanced(scaled(problem, factor), steps)
            bits = differing_values(_scaled_state(ordered(small.particles), factor), ordered(large.particles))
            bits += large.time != small.time * factor
            yield at_most(
                f"{geometry}, {SMALL['speed'] / 1e3:g} km/s, {steps} steps, 2^{power} times as large: "
                "values that differ",
                limit=0,
                got=bits,
            )


def _scaled_state(particles: Particles, factor: float) -> Particles:
    return particles._replace(position=particles.position * factor, mass=particles.mass * factor**3)


CASE = Case(
    name="similarity",
    says="geometric similarity holds bit for bit",
    source="dimensional analysis; multiplication by 2^n is exact (IEEE 754)",
    run=_run,
)
