"""Presets fill what was left out, and a run is what they fill in; offsets shift the grid and nothing else."""

import dataclasses
from collections.abc import Iterator
from typing import Any, get_args

import numpy as np
import pytest

from solver.grid.shapes.gimp import Gimp
from solver.grid.shapes.linear import Linear
from solver.grid.shapes.quadratic_bspline import QuadraticBSpline
from solver.matter.tensor import Jaumann, Unturned
from solver.problem import Contact, Criterion, Damping, Problem, Retirement, Scheme
from solver.simulation import Simulation, start
from studies import materials
from studies.quantities.findings import InvalidInput
from studies.quantities.parameters import declared
from studies.quantities.recipes import IMPACT_RECIPES, RECIPES, DebrisName, ImpactRecipe, Recipe, RecipeName
from studies.runs.execution import setting_of
from studies.runs.run import Run, estimate, resolve
from studies.scenarios.parts.numerics import BY_RECIPE, Numerics
from studies.scenarios.parts.shot import ImpactShot
from studies.sweeps.sweep import Sweep

COPPER = materials.load("copper-ofhc")
GIVEN: dict[str, Any] = {
    "speed": 4000.0,
    "projectile_diameter": 8e-3,
    "plate_thickness": 2e-3,
    "plate_radius": 16e-3,
    "projectile": "copper-ofhc",
    "target": "copper-ofhc",
    "cells_per_diameter": 8.0,
}


def asked(**changes: Any) -> Run:
    return resolve("thin_plate", {**GIVEN, **changes}, {"projectile": COPPER, "target": COPPER})


[OTHER_DEBRIS] = set(get_args(DebrisName)) - {IMPACT_RECIPES["whipple"].debris}


def chosen(name: RecipeName) -> dict[str, Any]:
    """All that a recipe chooses for an impact."""
    return {**dataclasses.asdict(RECIPES[name]), **dataclasses.asdict(IMPACT_RECIPES[name])}


# Recipes


def test_recipes__are_those_that_a_parameter_may_name() -> None:
    assert set(RECIPES) == set(IMPACT_RECIPES) == set(get_args(RecipeName))


def test_recipe__decides_every_numerical_parameter_that_may_be_left_out() -> None:
    optional = {name for name, one in declared(Numerics).items() if one.optional}
    # Left out, they stay out: the stable step, and the film's usual interval.
    no_numerics = {"fixed_dt", "film_interval"}
    assert {one.name for one in dataclasses.fields(Recipe)} == optional - no_numerics


def test_recipe__decides_every_parameter_of_impacts_that_is_said_to_be_its_own() -> None:
    own = {name for name, one in declared(ImpactShot).items() if one.meaning.endswith(BY_RECIPE)}
    assert {one.name for one in dataclasses.fields(ImpactRecipe)} == own


@pytest.mark.parametrize("name", list(RECIPES))
def test_recipe__holds_what_its_parameters_allow(name: RecipeName) -> None:
    assert asked(**chosen(name)).id == asked(recipe=name).id


def test_thesis__is_what_the_solver_does_without_being_told() -> None:
    """Both are Ma (2005) with the viscosity of MPM3D-F90."""
    plain = {one.name: one for one in dataclasses.fields(Problem)}
    for name, value in Numerics(recipe="thesis").filled().arguments().items():
        default = plain[name]
        made = default.default_factory is not dataclasses.MISSING
        expected = default.default_factory() if made else default.default  # type: ignore[operator]
        assert value == (Linear() if name == "shape" else expected), name  # without one, the solver takes linear ones


# Particles


@pytest.mark.parametrize(
    ("changes", "axisymmetric", "quarter"),
    [({}, 3, 2), ({"recipe": "thesis"}, 2, 2), ({"particles_per_cell": 4}, 4, 4)],
)
def test_particles__are_what_is_stated_then_what_the_geometry_then_what_the_recipe_says(
    changes: dict[str, Any], axisymmetric: int, quarter: int
) -> None:
    for geometry, count in (("axisymmetric", axisymmetric), ("quarter", quarter)):
        run = asked(geometry=geometry, **changes)
        assert run.parameters["particles_per_cell"] == count
        assert run.id == asked(**{**changes, "geometry": geometry, "particles_per_cell": count}).id


@pytest.mark.parametrize(
    ("accuracy", "fixed", "count"),
    [
        ("draft", {}, 2),
        ("standard", {}, 3),
        ("standard", {"geometry": "quarter"}, 2),
        ("draft", {"particles_per_cell": 3}, 3),
    ],
)
def test_particles__of_an_accuracy_give_way_to_a_stated_number_alone(
    accuracy: str, fixed: dict[str, Any], count: int
) -> None:
    shot = {"projectile_diameter": "8 mm", "plate_thickness": "2 mm"}
    copper = {"projectile": "copper-ofhc", "target": "copper-ofhc"}
    document = {"scenario": "thin_plate", "fixed": {**shot, **copper, **fixed}, "axes": {"speed": ["4 km/s"]}}
    sweep = Sweep.parse({**document, "accuracy": accuracy})
    for same in (sweep, Sweep.parse(sweep.document()), sweep.at_accuracy("fine").at_accuracy(accuracy)):
        assert {point.run.parameters["particles_per_cell"] for point in same.runs()} == {count}


@pytest.mark.parametrize("geometry", ["axisymmetric", "quarter"])
def test_particles__of_a_taylor_bar_are_those_of_the_recipe(geometry: str) -> None:
    document = {"scenario": "taylor_bar", "fixed": {"geometry": geometry}, "axes": {"speed": ["190 m/s"]}}
    (point,) = Sweep.parse({**document, "accuracy": "draft"}).runs()
    assert point.run.parameters["particles_per_cell"] == 3


# Identity


def test_identity__is_of_the_values_and_not_of_the_name() -> None:
    assert asked(recipe="thesis").id == asked(recipe="whipple", **chosen("thesis")).id
    assert asked(recipe="thesis").id != asked(recipe="whipple").id


# What the solver gets


@pytest.mark.parametrize(
    ("change", "name", "expected"),
    [
        ({"shape": "linear"}, "shape", Linear()),
        ({"shape": "quadratic-bspline"}, "shape", QuadraticBSpline()),
        ({"shape": "gimp", "particles_per_cell": 2}, "shape", Gimp(0.25)),
        ({"shape": "gimp", "particles_per_cell": 4}, "shape", Gimp(0.125)),
        ({"scheme": "usf"}, "scheme", Scheme.USF),
        ({"damping_rate": 2e4, "damping_order": 2}, "damping", Damping(2e4, 2)),
        ({}, "contact", None),
        ({"contact": "bardenhagen", "friction": 0.3}, "contact", Contact(0.3)),
        ({"contact": "thesis"}, "contact", Contact(0.0, Criterion.MAPPED)),
        ({}, "stress_rate", Jaumann()),
        ({"jaumann": False}, "stress_rate", Unturned()),
        ({"fixed_dt": 1e-9}, "fixed_dt", 1e-9),
        ({"debris": "follow"}, "retirement", None),
        ({"recipe": "thesis"}, "retirement", None),
        # Five times in which 8 mm are flown at 4 km/s.
        ({"debris": "retire"}, "retirement", Retirement(body=1, after=1e-5)),
    ],
)
def test_numerics__become_what_the_solver_takes(change: dict[str, Any], name: str, expected: object) -> None:
    problem = setting_of(asked(**change)).problem
    assert getattr(problem, name) == expected
    assert type(getattr(problem, name)) is type(expected)


def test_friction__without_contact_is_refused() -> None:
    assert [one.field for one in Numerics(friction=0.1).check(None)] == ["friction"]
    assert not Numerics(friction=0.1, contact="bardenhagen").check(None)
    with pytest.raises(InvalidInput, match="friction"):
        asked(friction=0.1)


@pytest.mark.parametrize("geometry", ["axisymmetric", "quarter"])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_particles__are_as_many_as_asked_and_estimated(geometry: str, count: int) -> None:
    """A plate of two by sixteen cells; the sphere beside it has 5 % of the particles, counted by its volume."""
    run = asked(geometry=geometry, particles_per_cell=count, cells_per_diameter=8.0)
    target = setting_of(run).problem.bodies[1]
    axes = 2 if geometry == "axisymmetric" else 3
    assert target.mass.size == 2 * 16 ** (axes - 1) * count**axes
    particles = sum(body.mass.size for body in setting_of(run).problem.bodies)
    assert estimate(run).particles == pytest.approx(particles, rel=0.1)


def test_estimate__knows_the_shape_and_the_recipe() -> None:
    linear, wide = (asked(shape=shape, geometry="quarter") for shape in ("linear", "gimp"))
    assert estimate(linear).core_seconds < estimate(wide).core_seconds
    assert estimate(asked(courant=0.15)).steps == pytest.approx(2 * estimate(asked(courant=0.3)).steps, abs=1)


# Debris and grid


def test_grid__reaches_as_far_as_it_is_told() -> None:
    """Before the target at z = 0, behind its back at 2 mm, and beyond its rim at 16 mm; diameters of 8 mm."""
    run = asked(uprange=1.5, downrange=3.0, beyond_edge=0.75, edges="free")
    grid = setting_of(run).problem.geometry
    upper = grid.lower + grid.spacing * grid.cells
    assert grid.lower[:2] == pytest.approx([0.0, -12e-3])
    assert upper[:2] == pytest.approx([22e-3, 26e-3])


# Offset


def advanced(run: Run, steps: int) -> Simulation:
    simulation = start(setting_of(run).problem, threads=1)
    for _ in range(steps):
        simulation.advance()
    return simulation


@pytest.fixture(params=["axisymmetric", "quarter"])
def geometry(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def flight(geometry: str) -> int:
    return 1 if geometry == "axisymmetric" else 2


def test_offset__shifts_the_grid_along_the_flight_and_no_body(geometry: str) -> None:
    aligned, shifted = (setting_of(asked(geometry=geometry, offset=offset)).problem for offset in (0.0, 0.25))
    shift = np.asarray(shifted.geometry.lower) - np.asarray(aligned.geometry.lower)
    expected = np.zeros(3)
    expected[flight(geometry)] = -0.25 * aligned.geometry.spacing
    assert shift == pytest.approx(expected, abs=1e-15)
    for one, other in zip(aligned.bodies, shifted.bodies, strict=True):
        assert np.array_equal(one.position, other.position)
        assert np.array_equal(one.mass, other.mass)


def by_number(simulation: Simulation) -> Iterator[np.ndarray]:
    order = np.argsort(simulation.particles.number)
    yield simulation.particles.position[order]
    yield simulation.particles.velocity[order]
    yield simulation.particles.density[order]


def test_offset__of_a_whole_cell_changes_round_off_only(geometry: str) -> None:
    """Sixty steps amplify the round-off of positions in cells, 1e-15, by a few orders."""
    aligned, shifted = (advanced(asked(geometry=geometry, offset=x), 60) for x in (0.0, 1.0))
    for one, other in zip(by_number(aligned), by_number(shifted), strict=True):
        assert np.abs(one - other).max() < 1e-9 * np.abs(one).max()


# Accuracy


# Blocks


def test_block__may_grow_twice_as_long_as_a_plate() -> None:
    """15 ms per metre of diameter, R sqrt(rho / Y) of three diameters of copper at 350 MPa."""
    block = {name: value for name, value in GIVEN.items() if not name.startswith("plate")}
    run = resolve("thick_plate", block, {"projectile": COPPER, "target": COPPER})
    ends = [one.parameters["end_time"] for one in (run, asked())]
    assert ends == pytest.approx([2.0 * 60e-6, 60e-6])
    assert ends[0] == pytest.approx(3.0 * 8e-3 * (8930.0 / 350e6) ** 0.5, rel=0.02)
