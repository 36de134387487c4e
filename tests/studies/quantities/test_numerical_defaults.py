"""Presets fill what was left out, and a run is what they fill in; offsets shift the grid and nothing else."""

import dataclasses
from typing import Any, get_args

import numpy as np
import pytest

from solver.grid.shapes.gimp import Gimp
from solver.matter.tensor import Unturned
from solver.problem import Contact, Criterion, Damping, Retirement
from studies.quantities.numerical_defaults import IMPACT_RECIPES, RECIPES, ImpactRecipe, Recipe, RecipeName
from studies.quantities.parameters import declared
from studies.runs.stages import setting_of
from studies.scenarios.parts.numerics import BY_RECIPE, Numerics
from studies.scenarios.parts.shot import ImpactShot
from tests.contracts.test_scenarios import asked

# Recipes


def test_recipe__decides_every_numerical_parameter_that_may_be_left_out() -> None:
    assert set(RECIPES) == set(IMPACT_RECIPES) == set(get_args(RecipeName))
    optional = {name for name, one in declared(Numerics).items() if one.default is None and not one.required}
    # Left out, they stay out: the stable step, and the film's usual interval.
    assert {one.name for one in dataclasses.fields(Recipe)} == optional - {"fixed_dt", "film_interval"}
    of_impacts = {name for name, one in declared(ImpactShot).items() if one.meaning.endswith(BY_RECIPE)}
    assert {one.name for one in dataclasses.fields(ImpactRecipe)} == of_impacts


# Particles


@pytest.mark.parametrize(
    ("changes", "axisymmetric", "quarter"),
    [({}, 3, 2), ({"recipe": "thesis"}, 2, 2), ({"particles_per_cell": 4}, 4, 4)],
)
def test_particles__are_what_is_stated_then_what_the_geometry_then_what_the_recipe_says(
    changes: dict[str, Any], axisymmetric: int, quarter: int
) -> None:
    for geometry, count in (("axisymmetric", axisymmetric), ("quarter", quarter)):
        run = asked("thin_plate", geometry=geometry, **changes)
        assert run.parameters["particles_per_cell"] == count
        assert run.id == asked("thin_plate", **{**changes, "geometry": geometry, "particles_per_cell": count}).id


# What the solver gets


@pytest.mark.parametrize(
    ("change", "name", "expected"),
    [
        ({"shape": "gimp", "particles_per_cell": 2}, "shape", Gimp(0.25)),
        ({"shape": "gimp", "particles_per_cell": 4}, "shape", Gimp(0.125)),
        ({"damping_rate": 2e4, "damping_order": 2}, "damping", Damping(2e4, 2)),
        ({"contact": "bardenhagen", "friction": 0.3}, "contact", Contact(0.3)),
        ({"contact": "thesis"}, "contact", Contact(0.0, Criterion.MAPPED)),
        ({"jaumann": False}, "stress_rate", Unturned()),
        ({"debris": "follow"}, "retirement", None),
        ({"recipe": "thesis"}, "retirement", None),
        # Five times in which 8 mm are flown at 4 km/s.
        ({"debris": "retire", "speed": 4000.0}, "retirement", Retirement(body=1, after=1e-5)),
    ],
)
def test_numerics__become_what_the_solver_takes(change: dict[str, Any], name: str, expected: object) -> None:
    problem = setting_of(asked("thin_plate", **change)).problem
    assert getattr(problem, name) == expected
    assert type(getattr(problem, name)) is type(expected)


@pytest.mark.parametrize(("geometry", "flight"), [("axisymmetric", 1), ("quarter", 2)])
def test_offset__shifts_the_grid_along_the_flight_and_no_body(geometry: str, flight: int) -> None:
    aligned, shifted = (
        setting_of(asked("thin_plate", geometry=geometry, offset=offset)).problem for offset in (0.0, 0.25)
    )
    shift = np.asarray(shifted.geometry.lower) - np.asarray(aligned.geometry.lower)
    assert shift == pytest.approx(-0.25 * aligned.geometry.spacing * np.eye(3)[flight], abs=1e-15)
    for one, other in zip(aligned.bodies, shifted.bodies, strict=True):
        assert np.array_equal(one.position, other.position)
        assert np.array_equal(one.mass, other.mass)
