"""Mirror images, and a quarter against the whole of which it is the quarter."""

from collections.abc import Iterator

import numpy as np

from solver.problem import Problem
from solver.state import Particles
from studies.values.recipes import Recipe
from studies.verification import Case, Row, at_most
from studies.verification._impacts import (
    ROUND_OFF,
    SMALL,
    STEPS,
    advanced,
    gap,
    image,
    impact_setting,
    mirrored,
    ordered,
    unfolded,
)

OBLIQUITY = 0.5  # rad
# Of a whole plate, and the axes across which they are images of the first.
QUARTERS = {"the first": (), "the image in x": (0,), "that in y": (1,), "that in both": (0, 1)}


def _run(recipe: Recipe) -> Iterator[Row]:
    speed = float(SMALL["speed"])
    oblique = impact_setting(recipe, geometry="half", obliquity=OBLIQUITY).problem
    turned = image(ordered(advanced(mirrored(oblique)).particles))
    straight = ordered(advanced(oblique).particles)
    yield at_most(
        f"oblique impact and its mirror image, {STEPS} steps: largest difference",
        limit=ROUND_OFF,
        got=gap(straight, turned, spacing=oblique.geometry.spacing, speed=speed).largest,
    )

    quarter = impact_setting(recipe, geometry="quarter").problem
    part = ordered(advanced(quarter).particles)
    whole = ordered(advanced(unfolded(unfolded(quarter, 0), 1)).particles)
    for name, other in zip(QUARTERS, _quarters(whole, quarter), strict=True):
        yield at_most(
            f"quarter against {name} of the whole, {STEPS} steps: largest difference",
            limit=ROUND_OFF,
            got=gap(part, other, spacing=quarter.geometry.spacing, speed=speed).largest,
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


CASE = Case(
    name="mirror", says="mirror image and quarter against whole: round-off for 50 steps", source="symmetry", run=_run
)
