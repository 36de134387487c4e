"""What every scenario must do: declare its fields, build at its corners with the right masses, start in balance."""

import dataclasses
import itertools
import math
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest

from solver.audit import Audit
from solver.geometry import impact_axis
from solver.simulation import start
from solver.units import units_of
from studies import materials, measurements, scenarios
from studies.parameters import Parameter, declared
from studies.run import Run, materials_of, resolve
from studies.scenarios import Scenario, Setting

DIAMETER, CELLS = 8e-3, 4.0
ROUND_OFF = 1e-12
MOMENTUM, ENERGY = 1e-10, 0.01  # what ten steps may lose, of the initial values
ESTIMATE = 3.0  # factor within which the estimated number of particles must lie

# A scenario's own parameters, small; a new scenario brings its own.
SMALL: dict[str, dict[str, float]] = {
    "thin_plate": {"plate_thickness": 4e-3, "plate_radius": 1.5 * DIAMETER},
    "thick_plate": {"target_depth": 1.5 * DIAMETER, "target_radius": 1.5 * DIAMETER},
}
GEOMETRIES = ("axisymmetric", "quarter", "half")
SHAPES = ("sphere", "cylinder")
EDGES = ("fixed", "free")
CORNERS = tuple(itertools.product(sorted(SMALL), GEOMETRIES, SHAPES, EDGES))
# Each is a corner by itself, on the axisymmetric sphere; the far ends of what the fields allow among them.
VARIATIONS: tuple[dict[str, Any], ...] = (
    {"eos_form": "cubic"},
    {"thermal_softening": False},
    {"tension": "unlimited"},
    {"speed": 100.0},
    {"speed": 20e3},
    {"cells_per_diameter": 2.0},
    {"cells_per_diameter": 64.0},
    {"courant": 0.01},
    {"courant": 0.9},
    {"viscosity_linear": 0.0, "viscosity_quadratic": 0.0},
    {"fixed_dt": 1e-9},
    {"projectile_shape": "cylinder", "projectile_length": 5.0 * DIAMETER},
    {"projectile": "al-2024-t3"},
    {"target": "al-2024-t3"},
)


def asked(scenario: str, **changes: Any) -> Run:
    """A run of copper at low resolution."""
    given = {
        "speed": 3000.0,
        "projectile_diameter": DIAMETER,
        "projectile": "copper-ofhc",
        "target": "copper-ofhc",
        "cells_per_diameter": CELLS,
        **SMALL[scenario],
        **changes,
    }
    roles = scenarios.load(scenario).materials
    return resolve(scenario, given, {role: materials.load(str(given[role])) for role in roles})


@cache
def corner(scenario: str, geometry: str, shape: str, edges: str) -> tuple[Run, Setting]:
    """A run and what it builds; kept, because each record of an equation of state integrates its isentrope."""
    length = {"projectile_length": 0.75 * DIAMETER} if shape == "cylinder" else {}
    run = asked(scenario, geometry=geometry, projectile_shape=shape, edges=edges, **length)
    return run, built(run)


def built(run: Run) -> Setting:
    scenario = scenarios.load(run.scenario)
    return scenario.build(scenario.parameters(**run.parameters), materials_of(run))


def fields(scenario: Scenario) -> Iterator[Parameter]:
    yield from declared(scenario.parameters).values()


def ten_steps(setting: Setting) -> Audit:
    simulation = start(setting.problem, threads=1)
    for _ in range(10):
        simulation.advance()
    return simulation.audit()


@pytest.fixture(params=scenarios.names())
def scenario(request: pytest.FixtureRequest) -> Scenario:
    return scenarios.load(request.param)


@pytest.fixture(params=CORNERS, ids="-".join)
def at_corner(request: pytest.FixtureRequest) -> tuple[Run, Setting]:
    return corner(*request.param)


@pytest.fixture
def run(at_corner: tuple[Run, Setting]) -> Run:
    return at_corner[0]


@pytest.fixture
def setting(at_corner: tuple[Run, Setting]) -> Setting:
    return at_corner[1]


@pytest.fixture(params=VARIATIONS, ids=lambda one: "-".join(f"{k}-{v}" for k, v in one.items()))
def variation(request: pytest.FixtureRequest) -> dict[str, Any]:
    changes: dict[str, Any] = request.param
    return changes


def test_scenario__brings_small_parameters() -> None:
    assert set(SMALL) == set(scenarios.names()), "give each scenario its small parameters above"


def test_scenario__describes_itself(scenario: Scenario) -> None:
    assert scenario.title
    assert scenario.description.endswith(".")


def test_scenario__states_the_meaning_of_every_field(scenario: Scenario) -> None:
    assert [field.name for field in fields(scenario) if not field.meaning] == []


def test_scenario__states_unit_and_bounds_of_every_number(scenario: Scenario) -> None:
    units = units_of(scenario.parameters)
    for field in fields(scenario):
        if field.kind in ("quantity", "integer"):
            assert field.unit == units[field.name]
            assert field.minimum is not None
            assert field.maximum is not None
            assert field.minimum < field.maximum


def test_scenario__has_defaults_within_the_bounds(scenario: Scenario) -> None:
    for field in fields(scenario):
        if field.minimum is not None and field.maximum is not None and field.default is not None:
            assert field.minimum <= float(field.default) <= field.maximum


def test_scenario__takes_its_parameters_by_keyword_and_keeps_them(scenario: Scenario) -> None:
    options = scenario.parameters.__dataclass_params__  # type: ignore[attr-defined]
    assert options.frozen
    assert all(field.kw_only for field in dataclasses.fields(scenario.parameters))


def test_scenario__names_fields_measurements_and_materials_that_exist(scenario: Scenario) -> None:
    known = declared(scenario.parameters)
    assert all(known[name].kind == "material" for name in scenario.materials)
    assert set(scenario.measurements) <= set(measurements.names())
    assert set(scenario.settles) <= set(scenario.measurements)


def test_scenario__says_how_well_it_is_resolved(scenario: Scenario) -> None:
    given = scenario.parameters(**asked(scenario.name).parameters)
    cells = scenario.cells(given)
    assert set(cells) == {"cells_per_diameter", "cells_per_thickness"}
    assert cells["cells_per_diameter"] == CELLS
    thickness = built(asked(scenario.name)).thickness
    assert math.isclose(cells["cells_per_thickness"], thickness / DIAMETER * CELLS)


def test_build__weighs_what_the_bodies_weigh(run: Run, setting: Setting) -> None:
    """Per radian, or the part that the model covers."""
    projectile, target = setting.problem.bodies
    part = 1.0 if setting.sector == 1.0 else setting.sector / (2.0 * math.pi)
    whole = 2.0 * math.pi if setting.sector == 1.0 else 1.0
    length = run.parameters["projectile_length"]
    ball = math.pi / 6.0 * DIAMETER**3
    rod = math.pi / 4.0 * DIAMETER**2 * float(length or 0.0)
    volume = (rod if length else ball) * part / whole
    assert math.isclose(projectile.mass.sum(), projectile.density * volume, rel_tol=ROUND_OFF)
    # A round target in axisymmetry, a square one otherwise.
    face = math.pi * setting.radius**2 / whole if whole > 1.0 else 4.0 * setting.radius**2 * part
    assert math.isclose(
        target.mass.sum(), target.density * face * setting.thickness, rel_tol=ROUND_OFF
    )


def test_build__gives_every_particle_a_mass_and_no_two_the_same_place(setting: Setting) -> None:
    for body in setting.problem.bodies:
        assert body.mass.min() > 0.0
        assert len(np.unique(body.position.round(9), axis=0)) == body.mass.size


def test_build__puts_the_projectile_in_front_of_the_target(run: Run, setting: Setting) -> None:
    axis = impact_axis(setting.problem.geometry)
    projectile, target = setting.problem.bodies
    assert projectile.position[:, axis].max() < 0.0 < target.position[:, axis].min()
    assert target.position[:, axis].max() < setting.thickness
    assert np.flatnonzero(projectile.velocity).tolist() == [axis]
    assert projectile.velocity[axis] == run.parameters["speed"]
    assert not target.velocity.any()


def test_build__lets_projectile_and_target_touch_at_the_start(setting: Setting) -> None:
    axis = impact_axis(setting.problem.geometry)
    projectile, target = setting.problem.bodies
    gap = target.position[:, axis].min() - projectile.position[:, axis].max()
    # Half a particle of each stands between the outermost points, and a lattice sphere has its pole on a lattice plane.
    assert gap <= 0.5 * (projectile.spacing[axis] + target.spacing[axis]) * (1.0 + 1e-9)


def test_build__keeps_the_balance_over_ten_steps(setting: Setting) -> None:
    audit = ten_steps(setting)
    assert audit.mass_error <= ROUND_OFF
    assert audit.momentum_error <= MOMENTUM
    assert abs(audit.energy_drift) <= ENERGY


def test_variation__keeps_the_balance_over_ten_steps(
    scenario: Scenario, variation: dict[str, Any]
) -> None:
    audit = ten_steps(built(asked(scenario.name, **variation)))
    assert audit.mass_error <= ROUND_OFF
    assert audit.momentum_error <= MOMENTUM
    assert abs(audit.energy_drift) <= ENERGY


def test_estimate__is_near_the_real_number_of_particles(run: Run, setting: Setting) -> None:
    scenario = scenarios.load(run.scenario)
    size = scenario.estimate(scenario.parameters(**run.parameters), materials_of(run))
    real = sum(body.mass.size for body in setting.problem.bodies)
    assert real / ESTIMATE < size.particles < real * ESTIMATE


def test_estimate__grows_with_resolution(scenario: Scenario) -> None:
    sizes = []
    for cells in (8.0, 16.0):
        given = asked(scenario.name, cells_per_diameter=cells)
        sizes.append(
            scenario.estimate(scenario.parameters(**given.parameters), materials_of(given))
        )
    assert math.isclose(sizes[1].particles / sizes[0].particles, 4.0, rel_tol=0.01)
    assert math.isclose(sizes[1].steps / sizes[0].steps, 2.0, rel_tol=0.01)
