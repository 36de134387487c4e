"""Plane impact of solids without strength: pressure, density and energy behind the fronts, and their speed."""

from collections.abc import Iterator
from functools import partial

from studies.values.recipes import Recipe
from studies.verification import Case, Row, absolute, relatives, reported
from studies.verification._collision import Collision, Piece, Wave, collide, collision_problem, waves
from studies.verification._hugoniot import (
    ALUMINIUM_2024,
    ALUMINIUM_6061,
    ALUMINIUM_WILKINS,
    COPPER,
    COPPER_WILKINS,
    IRON,
    LEAD,
    STEEL_304,
    TITANIUM_6AL_4V,
    TUNGSTEN,
    Shock,
    Solid,
    impedance_match,
)
from studies.verification._matter import fluid

# Set before any run. Smooth shapes are held to their pressure; linear cells, whose particle density drifts where
# particles cross cells, are reported.
PRESSURE = {"quadratic-bspline": 0.015, "gimp": 0.02}
SHOCK_SPEED, DENSITY = 0.01, 0.005

SPEEDS = (2e3, 3e3, 4e3, 5e3, 6e3, 7e3)  # m/s
QUICK_SPEEDS = (2e3, 6e3)
PAIRS = (
    *((COPPER, COPPER, speed) for speed in SPEEDS),
    *((ALUMINIUM_2024, COPPER, speed) for speed in (2e3, 4e3, 6e3, 7e3)),
    *((TUNGSTEN, COPPER, speed) for speed in (2e3, 4e3, 6e3)),
)

# The other metals of the reference table: the recipe was chosen without them, its study measures ``PAIRS`` alone.
SYMMETRIC = (ALUMINIUM_2024, ALUMINIUM_6061, LEAD, IRON, STEEL_304, TUNGSTEN, TITANIUM_6AL_4V)
METAL_PAIRS = (
    (ALUMINIUM_WILKINS, COPPER_WILKINS, 0.7e3),
    (ALUMINIUM_WILKINS, COPPER_WILKINS, 1.0e3),
    (STEEL_304, ALUMINIUM_2024, 3.1e3),
    *((solid, solid, speed) for solid in SYMMETRIC for speed in SPEEDS),
)


def impact(flyer: Solid, target: Solid, speed: float, recipe: Recipe, *, boost: float = 0.0) -> Collision:
    """The collision of two solids at a speed (m/s), seen from a frame that moves the other way by ``boost``."""
    states = impedance_match(flyer, target, speed)
    first, second = (
        Piece(fluid(solid), solid.density, state.shock_speed)
        for solid, state in zip((flyer, target), states, strict=True)
    )
    return collide(collision_problem(first, second, speed, recipe, boost=boost))


def states(flyer: Solid, target: Solid, speed: float, result: Collision) -> Iterator[tuple[str, Shock, Wave]]:
    """Each body, the exact state behind its shock, and the one that was found."""
    exact = dict(zip(("flyer", "target"), impedance_match(flyer, target, speed), strict=True))
    for body, wave in waves(result):
        yield body, exact[body], wave


def rows(flyer: Solid, target: Solid, speed: float, recipe: Recipe) -> Iterator[Row]:
    """Both waves of one impact against the impedance match."""
    result = impact(flyer, target, speed, recipe)
    for body, exact, wave in states(flyer, target, speed, result):
        got = wave.plateau
        where = f"{flyer.name} on {target.name}, {speed / 1e3:g} km/s, {body}"
        pressure = PRESSURE.get(recipe.shape)
        speed_error, density_error = (SHOCK_SPEED, DENSITY) if pressure else (None, None)
        figures = (exact.pressure / 1e9, got.stress / 1e9)
        yield from relatives(where, ("plateau pressure (GPa)", *figures, pressure))
        yield reported(f"{where}: scatter of the pressure (of its mean)", got.scatter)
        yield from relatives(
            where,
            ("shock speed (m/s)", exact.shock_speed, wave.speed, speed_error),
            ("particle density (kg/m3)", exact.density, got.density, density_error),
            ("density from the spacing (kg/m3)", exact.density, got.spacing_density, density_error),
            ("internal energy behind the front (MJ/kg)", exact.energy / 1e6, got.energy / 1e6, None),
        )
    yield absolute(
        f"{flyer.name} on {target.name}, {speed / 1e3:g} km/s: drift of the total energy",
        expected=0.0,
        got=result.outcome.audit.energy_drift,
    )


def _all(pairs: tuple[tuple[Solid, Solid, float], ...], recipe: Recipe) -> Iterator[Row]:
    for flyer, target, speed in pairs:
        yield from rows(flyer, target, speed, recipe)


SOURCE = "Rankine and Hugoniot with Us = c0 + s up; the constants are cited in _hugoniot.py"

CASE = (
    Case(
        name="plate-impact",
        says="the default recipe gives the states of a copper plate impact at 2 and 6 km/s",
        source=SOURCE,
        run=partial(_all, tuple((COPPER, COPPER, speed) for speed in QUICK_SPEEDS)),
    ),
    Case(
        name="plate-impact-all",
        says="at every speed and pair of materials of the reference table, copper and seven other metals, B-splines "
        "give P within 1.5 %, shock speed within 1 % and density within 0.5 %",
        source=SOURCE,
        run=partial(_all, (*PAIRS, *METAL_PAIRS)),
        quick=False,
    ),
)
