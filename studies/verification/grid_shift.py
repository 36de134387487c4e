"""A shift by whole cells changes nothing but round-off, and so does a flight by whole cells in every step."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from studies.values.recipes import Recipe
from studies.verification import Case, Row, at_most
from studies.verification._impacts import (
    ROUND_OFF,
    SMALL,
    STEPS,
    advanced,
    boosted,
    enlarged,
    gap,
    impact_setting,
    ordered,
    shifted,
)

SHIFT = 7  # cells
# Of a cell in a step of the quickest signal: a fixed step, so that the flight can be a whole cell in each.
COURANT = 0.1


def _run(recipe: Recipe) -> Iterator[Row]:
    for geometry, axis in (("axisymmetric", 1), ("quarter", 2)):
        # A held rim would not fly.
        setting = impact_setting(recipe, geometry=geometry, edges="free")
        speed, spacing = float(SMALL["speed"]), setting.problem.geometry.spacing
        along = (np.arange(3) == axis).astype(np.int64)
        room = enlarged(setting.problem, 0 * along, (SHIFT + STEPS) * along)
        problem = replace(room, fixed_dt=COURANT * spacing / speed)
        here = ordered(advanced(problem).particles)

        offset = SHIFT * spacing * along
        there = ordered(advanced(shifted(problem, offset)).particles)
        moved = there._replace(position=there.position - offset)
        yield at_most(
            f"{geometry}: {SHIFT} cells farther, {STEPS} steps: largest difference",
            limit=ROUND_OFF,
            got=gap(here, moved, spacing=spacing, speed=speed).largest,
        )

        flight = speed / COURANT * along  # one cell a step
        flown = advanced(boosted(problem, flight))
        after = ordered(flown.particles)
        still = after._replace(position=after.position - flight * flown.time, velocity=after.velocity - flight)
        yield at_most(
            f"{geometry}: one cell farther in every step, {STEPS} steps: largest difference",
            limit=ROUND_OFF,
            got=gap(here, still, spacing=spacing, speed=float(flight.max())).largest,
        )


CASE = Case(
    name="grid-shift",
    says="a shift by whole cells changes round-off only",
    source="the grid has no preferred cell",
    run=_run,
    quick=False,
)
