"""Presets: the numerics of a run under one name, and how well it is to be resolved.

A recipe fills the numerical parameters that a user left out (``studies.scenarios._numerics``); the identity of a run
is what it fills in, not its name. An accuracy is the resolutions and sub-cell offsets of a sweep. The number of
particles is, in this order, what the user states, that of a draft or of three dimensions, that of the recipe.
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


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """A choice for every numerical parameter; each field is a parameter of the same name."""

    shape: str  # name of an entry of solver.shapes
    scheme: SchemeName
    particles_per_cell: int  # along each direction
    viscosity_linear: Dimensionless
    viscosity_quadratic: Dimensionless
    courant: Dimensionless
    step_rule: StepRuleName
    travel: Dimensionless
    damping_rate: PerSecond
    damping_order: int
    tension: str  # name of an entry of solver.tension


@dataclass(frozen=True, kw_only=True)
class ImpactRecipe:
    """A choice for the numerical parameters of impacts alone; each field is a parameter of the same name."""

    debris: DebrisName
    uprange: Dimensionless  # projectile diameters
    downrange: Dimensionless


RECIPES: Mapping[RecipeName, Recipe] = MappingProxyType(
    {
        # Chosen by the rule of ``docs.recipe_study``, see docs/recipe.md: the cheapest recipe that holds every gate.
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


# Particles along each direction in drafts and in three dimensions, where three take two and three times as long; the
# difference is measured in docs/recipe.md, and is a part of the uncertainty of what they measure.
FEW_PARTICLES = 2


@dataclass(frozen=True)
class Accuracy:
    """Resolutions and offsets at which a sweep computes each of its points."""

    resolutions: tuple[float, ...]  # cells across the projectile's diameter, coarse to fine
    offsets: int  # sub-cell positions of the grid at each resolution, evenly spaced over a cell
    meaning: str
    few_particles: bool = False  # whether ``FEW_PARTICLES`` do where the user states no number


# Three grids, because an observed order needs them (Celik et al. 2008, J. Fluids Eng. 130, 078001, who ask for a
# ratio of more than 1.3); two leave an error bar of three times their difference. Through a plate of a quarter
# diameter 16, 32 and 64 cells are 4, 8 and 16: below 4 a plate has too few particles for a stress wave (flag
# ``under_resolved``). Three offsets, because the error bar of grids that differ by little is the scatter over them: of
# an error that varies once over a cell, two see between all and nothing, three always more than four fifths.
ACCURACY: Mapping[str, Accuracy] = MappingProxyType(
    {
        "draft": Accuracy(
            (16.0,),
            1,
            f"one grid, for trends: 16 cells across the diameter, {FEW_PARTICLES} particles along each direction",
            few_particles=True,
        ),
        "standard": Accuracy(
            (16.0, 24.0, 36.0),
            3,
            "three grids at three sub-cell offsets; an order and an extrapolated value where they differ by enough",
        ),
        "fine": Accuracy(
            (16.0, 32.0, 64.0), 3, "three finer grids, each twice as fine as the one before, at three sub-cell offsets"
        ),
    }
)
