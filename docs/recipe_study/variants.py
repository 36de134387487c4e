"""Variants of the recipe: each is a base with one changed choice."""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from studies.quantities.numerical_defaults import RECIPES, Recipe

# Both start from the same place; only the shape differs. Constants of viscosity between those of the codes below.
BASE = Recipe(
    shape="linear",
    scheme="musl",
    particles_per_cell=2,
    viscosity_linear=0.2,
    viscosity_quadratic=2.0,
    courant=0.3,
    step_rule="convective",
    travel=1.0,
    damping_rate=0.0,
    damping_order=1,
    tension="recoverable",
)
SHAPES: tuple[str, ...] = ("linear", "gimp", "quadratic-bspline")

# One choice at a time, around a base of each shape.
CHANGES: dict[str, tuple[dict[str, Any], ...]] = {
    "scheme": ({"scheme": "usf"}, {"scheme": "usl"}),
    "particles": ({"particles_per_cell": 3}, {"particles_per_cell": 4}),
    # MPM3D-F90's defaults, and then the linear part from none to strong.
    "viscosity": (
        {"viscosity_linear": 0.06, "viscosity_quadratic": 1.5},
        *({"viscosity_linear": linear, "viscosity_quadratic": 2.0} for linear in (0.0, 0.1, 0.15, 0.25, 0.3, 0.5)),
    ),
    "courant": ({"courant": 0.15}, {"courant": 0.4}, {"courant": 0.6}),
    # Times of 10 and 1 us: a hole takes 20, a shock crosses the plate in 0.4.
    "damping": ({"damping_rate": 1e5}, {"damping_rate": 1e6}, {"damping_rate": 1e6, "damping_order": 2}),
    "tension": ({"tension": "unlimited"},),
}


# Of the shapes that can hold the shocks, with so many particles along each direction of a cell: every pair of these.
SCANNED: tuple[str, ...] = ("gimp", "quadratic-bspline")
PARTICLES = (2, 3)
LINEAR, QUADRATIC = (0.0, 0.06, 0.1, 0.15, 0.2, 0.3), (1.5, 2.0, 3.0, 4.0, 6.0)


@dataclass(frozen=True)
class Variant:
    """A recipe under the name of what it changes."""

    name: str  # "quadratic-bspline", "quadratic-bspline, courant 0.4"
    group: str  # "preset", "base" or what is varied
    recipe: Recipe


def variants() -> Iterator[Variant]:
    """All variants, the presets and the bases first."""
    for preset, recipe in RECIPES.items():
        yield Variant(preset, "preset", recipe)
    for shape in SHAPES:
        yield Variant(shape, "base", replace(BASE, shape=shape))
    for shape in SHAPES:
        for group, changes in CHANGES.items():
            for change in changes:
                words = " ".join(_words(name, value) for name, value in change.items())
                recipe = replace(BASE, **{"shape": shape, **change})
                yield Variant(f"{shape}, {words}", group, recipe)


def scan() -> Iterator[Variant]:
    """The viscosities of each smooth shape and number of particles."""
    for shape, count, linear, quadratic in itertools.product(SCANNED, PARTICLES, LINEAR, QUADRATIC):
        recipe = replace(
            BASE, shape=shape, particles_per_cell=count, viscosity_linear=linear, viscosity_quadratic=quadratic
        )
        words = f"{shape}, {count} particles, q {linear:g} / {quadratic:g}"
        yield Variant(words, "scan", recipe)


def _words(name: str, value: Any) -> str:
    known = {
        "scheme": "{}",
        "particles_per_cell": "{} particles",
        "viscosity_linear": "q {:g}",
        "viscosity_quadratic": "/ {:g}",
        "courant": "courant {}",
        "damping_rate": "PIC {:g}/s",
        "damping_order": "of second order",
        "tension": "{} tension",
    }
    return known[name].format(value)
