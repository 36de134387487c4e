"""Plate impact of other metals: the symmetric and unlike pairs of the reference table beyond copper's own.

The recipe was chosen without them: the study of recipes measures ``plate_impact.PAIRS`` alone.
"""

from collections.abc import Iterator

from studies.values.recipes import Recipe
from studies.verification import Case, Row
from studies.verification._hugoniot import (
    ALUMINIUM_2024,
    ALUMINIUM_6061,
    ALUMINIUM_WILKINS,
    COPPER_WILKINS,
    IRON,
    LEAD,
    STEEL_304,
    TITANIUM_6AL_4V,
    TUNGSTEN,
)
from studies.verification.plate_impact import rows

SYMMETRIC = (
    ALUMINIUM_2024,
    ALUMINIUM_6061,
    LEAD,
    IRON,
    STEEL_304,
    TUNGSTEN,
    TITANIUM_6AL_4V,
)
SPEEDS = (2e3, 3e3, 4e3, 5e3, 6e3, 7e3)  # m/s
PAIRS = (
    (ALUMINIUM_WILKINS, COPPER_WILKINS, 0.7e3),
    (ALUMINIUM_WILKINS, COPPER_WILKINS, 1.0e3),
    (STEEL_304, ALUMINIUM_2024, 3.1e3),
    *((solid, solid, speed) for solid in SYMMETRIC for speed in SPEEDS),
)


def _run(recipe: Recipe) -> Iterator[Row]:
    for flyer, target, speed in PAIRS:
        yield from rows(flyer, target, speed, recipe)


CASE = Case(
    name="plate-impact-metals",
    title="Plate impact without strength: aluminium, lead, iron, steel, tungsten, titanium",
    source="Rankine and Hugoniot with Us = c0 + s up; the constants are cited in _hugoniot.py",
    run=_run,
    quick=False,
)
