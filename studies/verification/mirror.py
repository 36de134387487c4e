"""Mirror images, and a quarter against the whole of which it is the quarter."""

from collections.abc import Iterator

from studies.recipes import Recipe
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


def _run(recipe: Recipe) -> Iterator[Row]:
    import numpy as np

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
    first = []  # the originals among the images: body by body, one in four
    begin = 0
    for body in quarter.bodies:
        first.append(np.arange(begin, begin + body.mass.size))
        begin += 4 * body.mass.size
    originals = type(whole)(*(field[np.concatenate(first)] for field in whole))
    yield at_most(
        f"quarter against whole, {STEPS} steps: largest difference",
        limit=ROUND_OFF,
        got=gap(part, originals, spacing=quarter.geometry.spacing, speed=speed).largest,
    )


CASE = Case(
    name="mirror",
    title="Mirror image and quarter model against the whole, to round-off",
    source="symmetry",
    run=_run,
    quick=False,
)
