"""Defaults of the numerical parameters, as recipes: the numerics of a run under one name.

A recipe fills the numerical parameters that a user left out; the identity of a run is what it fills in, not its name.
The number of particles is, in this order, what the user states, that of three dimensions, that of the recipe.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal

from solver.units import Dimensionless, PerSecond

RecipeName = Literal["whipple", "thesis"]
SchemeName = Literal["musl", "usf", "usl"]
StepRuleName = Literal["acoustic", "convective"]
DebrisName = Literal["follow", "retire"]

# Of the failures that nothing excludes it converges best: docs/failure.md, by a rule that was written before its runs.
DEFAULT_FAILURE, NO_FAILURE = "void-growth", "none"


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """A choice for every numerical parameter; each field is a parameter of the same name."""

    shape: str  # name of an entry of solver.grid.shapes
    scheme: SchemeName
    particles_per_cell: int  # along each direction
    viscosity_linear: Dimensionless
    viscosity_quadratic: Dimensionless
    courant: Dimensionless
    step_rule: StepRuleName
    travel: Dimensionless
    damping_rate: PerSecond
    damping_order: int
    tension: str  # name of an entry of solver.matter.tension


@dataclass(frozen=True, kw_only=True)
class ImpactRecipe:
    """A choice for the numerical parameters of impacts alone; each field is a parameter of the same name."""

    debris: DebrisName
    uprange: Dimensionless  # projectile diameters
    downrange: Dimensionless


RECIPES: Mapping[RecipeName, Recipe] = MappingProxyType(
    {
        # Chosen by the rule of docs/recipe.md: the cheapest recipe that holds every gate.
        # With two particles splines miss the Taylor bar on the thesis' grid by a tenth, and GIMP's hole at 4 km/s
        # changes by more than 2 % from 8 to 16 cells through the plate.
        "whipple": Recipe(
            shape="quadratic-bspline",
            scheme="musl",
            particles_per_cell=3,
            viscosity_linear=0.2,
            viscosity_quadratic=4.0,
            courant=0.3,
            step_rule="acoustic",
            travel=0.5,
            damping_rate=0.0,
            damping_order=1,
            tension="recoverable",
        ),
        "thesis": Recipe(
            shape="linear",
            scheme="musl",
            particles_per_cell=2,
            viscosity_linear=0.06,
            viscosity_quadratic=1.5,
            courant=0.4,
            step_rule="convective",
            travel=1.0,
            damping_rate=0.0,
            damping_order=1,
            tension="recoverable",
        ),
    }
)

IMPACT_RECIPES: Mapping[RecipeName, ImpactRecipe] = MappingProxyType(
    {
        # Of the grids tried the smallest with the holes, the crater and all flags of the former grid, where debris was
        # followed: docs/recipe.md.
        "whipple": ImpactRecipe(debris="retire", uprange=2.5, downrange=4.0),
        "thesis": ImpactRecipe(debris="follow", uprange=2.5, downrange=5.0),
    }
)


# Particles along each direction in three dimensions, where three take three times as long; the difference is measured
# in docs/recipe.md, and is a part of the uncertainty of what they measure.
FEW_PARTICLES = 2
