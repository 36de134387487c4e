"""Tillotson's copper: states behind shocks, and the release of a shocked point until it is vapour."""

from collections.abc import Iterator

import numpy as np

from solver.matter.eos.tillotson import tillotson
from solver.matter.laws import Matter
from solver.matter.stress import PointState, advance
from solver.problem import ArtificialViscosity
from studies.quantities.numerical_defaults import Recipe
from tests.cases.verification import case
from tests.cases.verification.plate_impact import DENSITY as DENSITY_ERROR
from tests.cases.verification.plate_impact import PRESSURE, SHOCK_SPEED
from tests.cases.verification.setups.collision import Piece, collide, collision_problem
from tests.cases.verification.setups.matter import matter_of
from tests.cases.verification.solutions.hugoniot import Shock
from tests.cases.verification.solutions.tillotson import (
    ALPHA,
    BETA,
    DENSITY,
    E0,
    E_CV,
    E_IV,
    SMALL_A,
    SMALL_B,
    A,
    B,
    released,
    shocked,
)
from tests.claims.rows import Row, relatives

# By impact speed (m/s), the shares of the density at rest at which the released point is looked at. Copper shocked at
# 6 km/s stays condensed: thinner than at rest it is pulled, a matter of the tensile floor. At 15 it boils away.
SHARES = {6e3: [1.3, 1.0], 15e3: [1.0, 0.7, 0.4, 0.2, 0.1]}
STRAIN = 1e-3  # of the volume in a step
# Set before any run. The update is of second order in the strain of a step, and the branches meet in kinks.
RELEASED = 1e-3


@case(
    "tillotson",
    says="copper with Tillotson's equation of state has its exact shocks, and boils along its isentrope",
    source="Rankine and Hugoniot, and the isentrope de = p / rho^2 drho, with Tillotson (1962)",
)
def _run(recipe: Recipe) -> Iterator[Row]:
    for speed in SHARES:
        exact = shocked(0.5 * speed)
        yield from _shock(speed, exact, recipe)
        yield from _release(speed, exact)


def _shock(speed: float, exact: Shock, recipe: Recipe) -> Iterator[Row]:
    piece = Piece(_copper(), DENSITY, exact.shock_speed)
    wave = collide(collision_problem(piece, piece, speed, recipe)).target
    where = f"Cu (Tillotson) on Cu, {speed / 1e3:g} km/s"
    got, pressure = wave.plateau, PRESSURE.get(recipe.shape)
    yield from relatives(
        where,
        ("plateau pressure (GPa)", exact.pressure / 1e9, got.stress / 1e9, pressure),
        ("shock speed (m/s)", exact.shock_speed, wave.speed, SHOCK_SPEED),
        ("particle density (kg/m3)", exact.density, got.density, DENSITY_ERROR),
    )


def _release(speed: float, exact: Shock) -> Iterator[Row]:
    """One point, stretched at a constant rate, step by step."""
    matter, viscosity = _copper(), ArtificialViscosity()
    point = PointState(exact.density, exact.energy, exact.pressure, 0.0, (0.0,) * 6, 0.0, 300.0)
    path = [(point.density, point.pressure, point.energy)]
    gradient = np.eye(3) * STRAIN / 3.0
    while point.density > SHARES[speed][-1] * DENSITY:
        point, energy, _ = advance(matter, viscosity, 1.0, 1.0, gradient, point)
        point = point._replace(energy=energy)  # no step of the grid adds the other half of the work
        path.append((point.density, point.pressure, energy))
    density, pressures, energies = np.array(path[::-1]).T
    ends = released(exact, [share * DENSITY for share in SHARES[speed]])
    for share, (energy, pressure) in zip(SHARES[speed], ends, strict=True):
        where = f"released from {speed / 1e3:g} km/s to {share:g} of the density"
        place = share * DENSITY
        yield from relatives(
            where,
            ("pressure (GPa)", pressure / 1e9, float(np.interp(place, density, pressures) / 1e9), RELEASED),
            ("energy (MJ/kg)", energy / 1e6, float(np.interp(place, density, energies) / 1e6), RELEASED),
        )


def _copper() -> Matter:
    return matter_of(
        tillotson(
            density=DENSITY,
            a=SMALL_A,
            b=SMALL_B,
            A=A,
            B=B,
            e0=E0,
            e_iv=E_IV,
            e_cv=E_CV,
            alpha=ALPHA,
            beta=BETA,
            heat_capacity=383.0,
            temperature=300.0,
        )
    )


CASE = _run
