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
from solver.problem import Face
from solver.simulation import start
from solver.units import units_of
from studies import materials, measurements, scenarios
from studies.runs.run import Run, materials_of, resolve
from studies.scenarios import ImpactSetting, Scenario, Setting
from studies.scenarios.plate_impact import CROSSED, PlateSetting, shocks
from studies.values.errors import InvalidInput
from studies.values.parameters import Parameter, declared

DIAMETER, CELLS = 8e-3, 4.0
ROUND_OFF = 1e-12
MOMENTUM, ENERGY = 1e-10, 0.01  # what ten steps may lose, of the initial values
ESTIMATE = 3.0  # factor within which the estimated number of particles must lie

SHOT = {
    "speed": 3000.0,
    "projectile_diameter": DIAMETER,
    "projectile": "copper-ofhc",
    "target": "copper-ofhc",
    "cells_per_diameter": CELLS,
}
# A scenario's own parameters, small; a new scenario brings its own.
SMALL: dict[str, dict[str, Any]] = {
    "thin_plate": {**SHOT, "plate_thickness": 4e-3, "plate_radius": 1.5 * DIAMETER},
    "thick_plate": {**SHOT, "target_depth": 1.5 * DIAMETER, "target_radius": 1.5 * DIAMETER},
    "taylor_bar": {"bar_length": 10e-3, "bar_diameter": DIAMETER, "cells_per_diameter": CELLS},
    "elastic_bar": {"cells_per_diameter": CELLS},
    "plate_impact": {"flyer_thickness": 4e-3, "cells_per_thickness": 20.0},
}
# What says how fine the grid is, and what has that many cells.
RESOLUTION = {"plate_impact": ("cells_per_thickness", "cells_per_thickness")}
IMPACTS = ("thick_plate", "thin_plate")
BARS = ("elastic_bar", "taylor_bar")
GEOMETRIES = ("axisymmetric", "quarter", "half")
SHAPES = ("sphere", "cylinder")
EDGES = ("fixed", "free")
CORNERS = tuple(itertools.product(IMPACTS, GEOMETRIES, SHAPES, EDGES))
Changes = dict[str, Any]
# Each is a corner by itself, on the axisymmetric sphere; the far ends of what the fields allow among them.
NUMERICS: tuple[Changes, ...] = (
    {"recipe": "thesis"},
    {"courant": 0.01},
    {"courant": 0.9},
    {"particles_per_cell": 1},
    {"particles_per_cell": 4},
)
# The step does these alike whatever it was given: one scenario stands for all.
OF_THE_STEP: tuple[Changes, ...] = (
    {"tension": "unlimited"},
    {"viscosity_linear": 0.0, "viscosity_quadratic": 0.0},
    {"fixed_dt": 1e-9},
    {"scheme": "usf"},
    {"scheme": "usl"},
    {"shape": "gimp"},
    {"damping_rate": 1e5, "damping_order": 2},
)
OF_IMPACTS: tuple[Changes, ...] = (
    {"eos_form": "cubic"},
    {"thermal_softening": False},
    {"speed": 100.0},
    {"speed": 20e3},
    {"cells_per_diameter": 2.0},
    {"cells_per_diameter": 64.0},
    {"offset": 0.5},
    {"failure": "plastic-strain", "failure_strain": 0.5},
    {"projectile_shape": "cylinder", "projectile_length": 5.0 * DIAMETER},
    {"projectile": "al-2024-t3"},
    {"target": "al-2024-t3"},
)
OF_BARS: tuple[Changes, ...] = (
    {"geometry": "quarter"},
    {"geometry": "quarter", "recipe": "thesis"},
    {"wall": "symmetric"},
    {"wall": "symmetric", "geometry": "quarter"},
    {"cells_per_diameter": 2.0},
    {"cells_per_diameter": 2.0, "particles_per_cell": 1, "geometry": "quarter"},
    {"cells_per_diameter": 32.0},
    {"bar_length": 100e-3, "bar_diameter": 2e-3},
    {"speed": 1.0},
)
OF_PLATES: tuple[Changes, ...] = (
    {"geometry": "axisymmetric"},
    {"geometry": "axisymmetric", "recipe": "thesis"},
    {"cells_across": 3},
    {"cells_per_thickness": 10.0},
    {"cells_per_thickness": 300.0},
    {"target_thickness": 9e-3},
    {"flyer": "al-2024-t3"},
    {"target": "al-2024-t3"},
    {"strength": "material"},
    {"eos_form": "cubic"},
    {"speed": 20e3},
    {"speed": 1.0},
)
VARIATIONS: tuple[tuple[str, Changes], ...] = (
    *((name, change) for name in SMALL for change in NUMERICS),
    *(("thin_plate", change) for change in OF_THE_STEP),
    *((name, change) for name in IMPACTS for change in OF_IMPACTS),
    ("thin_plate", {"edges": "absorbing", "geometry": "quarter"}),
    ("thin_plate", {"edges": "absorbing", "geometry": "half", "offset": 0.5, "shape": "gimp"}),
    ("thick_plate", {"edges": "absorbing", "target_depth": 0.04, "target_radius": 0.04}),
    *((name, change) for name in BARS for change in OF_BARS),
    ("elastic_bar", {"poisson_ratio": 0.0}),
    ("elastic_bar", {"poisson_ratio": 0.49}),
    ("taylor_bar", {"bar": "al-2024-t3"}),
    ("taylor_bar", {"thermal_softening": False, "bar": "copper-ofhc"}),
    *(("plate_impact", change) for change in OF_PLATES),
)


def asked(scenario: str, **changes: Any) -> Run:
    """A run at low resolution."""
    given = {**SMALL[scenario], **changes}
    chosen = scenarios.load(scenario)
    defaults = declared(chosen.parameters)
    names = {role: str(given.get(role, defaults[role].default)) for role in chosen.materials}
    return resolve(scenario, given, {role: materials.load(name) for role, name in names.items()})


@cache
def corner(scenario: str, geometry: str, shape: str, edges: str) -> tuple[Run, ImpactSetting]:
    """A run and what it builds; kept, because each record of an equation of state integrates its isentrope."""
    length = {"projectile_length": 0.75 * DIAMETER} if shape == "cylinder" else {}
    run = asked(scenario, geometry=geometry, projectile_shape=shape, edges=edges, **length)
    return run, impact_setting(run)


def given_of(run: Run) -> Any:
    return scenarios.load(run.scenario).parameters(**run.parameters)


def built(run: Run) -> Setting:
    return scenarios.load(run.scenario).build(given_of(run), materials_of(run))


def impact_setting(run: Run) -> ImpactSetting:
    setting = built(run)
    assert isinstance(setting, ImpactSetting)
    return setting


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
def at_corner(request: pytest.FixtureRequest) -> tuple[Run, ImpactSetting]:
    return corner(*request.param)


@pytest.fixture
def run(at_corner: tuple[Run, ImpactSetting]) -> Run:
    return at_corner[0]


@pytest.fixture
def setting(at_corner: tuple[Run, ImpactSetting]) -> ImpactSetting:
    return at_corner[1]


@cache
def variation(number: int) -> tuple[Run, Setting]:
    """A run and what it builds."""
    name, changes = VARIATIONS[number]
    run = asked(name, **changes)
    return run, built(run)


@pytest.fixture(
    params=range(len(VARIATIONS)),
    ids=lambda at: "-".join(
        [VARIATIONS[at][0], *(f"{name}-{value}" for name, value in VARIATIONS[at][1].items())]
    ),
)
def varied(request: pytest.FixtureRequest) -> tuple[Run, Setting]:
    return variation(request.param)


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
            assert field.unit == units.get(field.name, "1")  # a whole number has none of its own
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
    for one in scenario.measurements:
        assert set(measurements.load(one).follows) <= set(scenario.measurements)
    assert set(scenario.watch.least_cells) <= set(scenario.cells(given_of(asked(scenario.name))))


def test_scenario__is_observed_often_enough_to_be_seen_growing(scenario: Scenario) -> None:
    run = asked(scenario.name)
    setting = built(run)
    pace = scenario.watch.pace(given_of(run), setting)
    assert 0.0 < pace.interval < setting.problem.end_time
    assert bool(scenario.settles) == math.isfinite(pace.window)
    if scenario.settles:
        assert pace.interval < pace.window < setting.problem.end_time


def test_scenario__is_measured_at_its_start(scenario: Scenario) -> None:
    """Whatever is measured has a value or a reason, before anything has happened."""
    setting = built(asked(scenario.name))
    seen = scenario.watch.view(setting, start(setting.problem, threads=1).snapshot())
    for one in scenario.measurements:
        measurement = measurements.load(one)
        if not measurement.follows:
            reading = measurement.read(seen)
            assert math.isfinite(reading.value) or reading.flags
    assert all(math.isfinite(number) for number in scenario.watch.numbers(seen).values())


def test_scenario__says_how_well_it_is_resolved(scenario: Scenario) -> None:
    parameter, word = RESOLUTION.get(scenario.name, ("cells_per_diameter",) * 2)
    run = asked(scenario.name)
    cells = scenario.cells(given_of(run))
    assert set(cells) <= {"cells_per_diameter", "cells_per_thickness"}
    assert cells[word] == run.parameters[parameter]


@pytest.mark.parametrize("impact", IMPACTS)
def test_impact__says_how_many_cells_its_target_has(impact: str) -> None:
    cells = scenarios.load(impact).cells(given_of(asked(impact)))
    thickness = impact_setting(asked(impact)).thickness
    assert math.isclose(cells["cells_per_thickness"], thickness / DIAMETER * CELLS)


def test_build__weighs_what_the_bodies_weigh(run: Run, setting: ImpactSetting) -> None:
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


def test_build__puts_the_projectile_in_front_of_the_target(
    run: Run, setting: ImpactSetting
) -> None:
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


def test_variation__keeps_the_balance_over_ten_steps(varied: tuple[Run, Setting]) -> None:
    audit = ten_steps(varied[1])
    assert audit.mass_error <= ROUND_OFF
    assert audit.momentum_error <= MOMENTUM
    assert abs(audit.energy_drift) <= ENERGY


def test_variation__gives_every_particle_a_mass_and_no_two_the_same_place(
    varied: tuple[Run, Setting],
) -> None:
    for body in varied[1].problem.bodies:
        assert body.mass.min() > 0.0
        assert len(np.unique(body.position.round(9), axis=0)) == body.mass.size


def test_variation__is_estimated_near_its_real_number_of_particles(
    varied: tuple[Run, Setting],
) -> None:
    run, setting = varied
    real = sum(body.mass.size for body in setting.problem.bodies)
    size = scenarios.load(run.scenario).estimate(given_of(run), materials_of(run))
    assert real / ESTIMATE < size.particles < real * ESTIMATE


def test_estimate__is_near_the_real_number_of_particles(run: Run, setting: Setting) -> None:
    scenario = scenarios.load(run.scenario)
    size = scenario.estimate(scenario.parameters(**run.parameters), materials_of(run))
    real = sum(body.mass.size for body in setting.problem.bodies)
    assert real / ESTIMATE < size.particles < real * ESTIMATE


def test_estimate__grows_with_resolution(scenario: Scenario) -> None:
    parameter, _ = RESOLUTION.get(scenario.name, ("cells_per_diameter",) * 2)
    sizes = []
    for cells in (16.0, 32.0):
        given = asked(scenario.name, **{parameter: cells})
        sizes.append(scenario.estimate(given_of(given), materials_of(given)))
    # A column of plates stays one cell wide.
    dimensions = 1 if scenario.name == "plate_impact" else 2
    assert math.isclose(sizes[1].particles / sizes[0].particles, 2.0**dimensions, rel_tol=0.01)
    assert math.isclose(sizes[1].steps / sizes[0].steps, 2.0, rel_tol=0.01)


# Bars and plates


@pytest.mark.parametrize("geometry", ["axisymmetric", "quarter"])
@pytest.mark.parametrize("name", BARS)
def test_bar__weighs_what_a_round_bar_weighs(name: str, geometry: str) -> None:
    run = asked(name, geometry=geometry)
    (bar,) = built(run).problem.bodies
    length, diameter = (float(str(run.parameters[f"bar_{x}"])) for x in ("length", "diameter"))
    part = 1.0 / (2.0 * math.pi) if geometry == "axisymmetric" else 0.25
    mass = bar.density * 0.25 * math.pi * diameter**2 * length * part
    assert math.isclose(bar.mass.sum(), mass, rel_tol=ROUND_OFF)


@pytest.mark.parametrize("geometry", ["axisymmetric", "quarter"])
@pytest.mark.parametrize("name", BARS)
def test_bar__stands_on_the_wall_and_flies_into_it(name: str, geometry: str) -> None:
    run = asked(name, geometry=geometry)
    problem = built(run).problem
    axis = impact_axis(problem.geometry)
    (bar,) = problem.bodies
    assert problem.geometry.lower[axis] == 0.0
    assert problem.faces[axis][0] == Face.WALL
    assert math.isclose(bar.position[:, axis].min(), 0.5 * bar.spacing[axis], rel_tol=1e-9)
    assert np.flatnonzero(bar.velocity).tolist() == [axis]
    assert bar.velocity[axis] == -float(str(run.parameters["speed"]))


@pytest.mark.parametrize("geometry", ["axisymmetric", "quarter"])
def test_taylor_bar__has_at_the_start_the_size_that_was_asked_for(geometry: str) -> None:
    """Exactly, whatever the lattice: it is what the final size is measured against."""
    scenario = scenarios.load("taylor_bar")
    setting = built(asked("taylor_bar", geometry=geometry, bar_length=11.1e-3))
    seen = scenario.watch.view(setting, start(setting.problem, threads=1).snapshot())
    for name, size in (
        ("final_length", 11.1e-3),
        ("mushroom_diameter", DIAMETER),
        ("width_at_fifth", DIAMETER),
    ):
        assert math.isclose(measurements.load(name).read(seen).value, size, rel_tol=1e-9)


def test_taylor_bar__is_by_default_the_one_of_the_thesis() -> None:
    """Ma (2005), section 2.3.2: 10 particles across the radius, 67 along, 5293 in a quarter."""
    material = materials.load("copper-thesis-taylor")
    run = resolve("taylor_bar", {"geometry": "quarter", "recipe": "thesis"}, {"bar": material})
    problem = built(run).problem
    assert problem.bodies[0].mass.size == 5293
    assert math.isclose(problem.geometry.spacing, 0.76e-3)
    assert math.isclose(problem.end_time, 72e-6)


def test_elastic_bar__is_by_default_the_one_of_the_thesis() -> None:
    """Ma (2005), section 2.3.1: 4 particles across the radius, 20 along, 260 in a quarter, cells of 1 mm."""
    problem = built(resolve("elastic_bar", {"geometry": "quarter", "recipe": "thesis"}, {})).problem
    assert problem.bodies[0].mass.size == 260
    assert math.isclose(problem.geometry.spacing, 1e-3)


def test_elastic_bar__leaves_room_for_the_rebound() -> None:
    setting = built(asked("elastic_bar"))
    problem = setting.problem
    top = problem.geometry.cells[1] * problem.geometry.spacing
    assert top > 10e-3 + 300.0 * problem.end_time


def test_elastic_bar__refuses_a_speed_beyond_elasticity() -> None:
    with pytest.raises(InvalidInput, match="speed"):
        asked("elastic_bar", young_modulus=1e9, speed=300.0)


@pytest.mark.parametrize("name", BARS)
def test_bar__refuses_to_be_shorter_than_a_cell(name: str) -> None:
    with pytest.raises(InvalidInput, match="bar_length"):
        asked(name, bar_length=0.5e-3)


@pytest.mark.parametrize("geometry", ["axisymmetric", "quarter"])
def test_plates__weigh_what_their_column_weighs(geometry: str) -> None:
    run = asked("plate_impact", geometry=geometry, target_thickness=6e-3, cells_across=2)
    width = 2 * 4e-3 / 20.0
    section = 0.5 * width**2 if geometry == "axisymmetric" else width**2
    for plate, thickness in zip(built(run).problem.bodies, (4e-3, 6e-3), strict=True):
        mass = plate.density * section * thickness
        assert math.isclose(plate.mass.sum(), mass, rel_tol=ROUND_OFF)


@pytest.mark.parametrize("geometry", ["axisymmetric", "quarter"])
def test_plates__touch_and_fly_in_the_frame_of_the_laboratory(geometry: str) -> None:
    problem = built(asked("plate_impact", geometry=geometry)).problem
    axis = impact_axis(problem.geometry)
    flyer, target = problem.bodies
    half = 0.5 * flyer.spacing[axis]
    assert math.isclose(flyer.position[:, axis].max(), -half, rel_tol=1e-9)
    assert math.isclose(target.position[:, axis].min(), half, rel_tol=1e-9)
    assert flyer.velocity[axis] == 2000.0
    assert not target.velocity.any()


@pytest.mark.parametrize("geometry", ["axisymmetric", "quarter"])
def test_plates__layers_are_counted_from_where_they_meet(geometry: str) -> None:
    setting = built(asked("plate_impact", geometry=geometry))
    assert isinstance(setting, PlateSetting)
    axis = impact_axis(setting.problem.geometry)
    place = np.concatenate([plate.position[:, axis] for plate in setting.problem.bodies])
    width = setting.problem.bodies[0].spacing[axis]
    assert np.allclose(np.abs(place), (setting.layer + 0.5) * width)


def test_plates__refuse_a_target_of_less_than_ten_cells() -> None:
    with pytest.raises(InvalidInput, match="target_thickness"):
        asked("plate_impact", target_thickness=1e-3)


# Shock states of reference copper (8930 kg/m3, 3940 m/s, 1.489) at half the impact speed, from the jump conditions.
SYMMETRIC_COPPER = (
    (2000.0, 5429.0, 48.48e9, 10946.3),
    (4000.0, 6918.0, 123.56e9, 12561.6),
    (7000.0, 9151.5, 286.03e9, 14460.4),
)


@pytest.mark.parametrize(("speed", "shock", "pressure", "density"), SYMMETRIC_COPPER)
def test_shocks__of_copper_on_copper_are_those_of_the_jump_conditions(
    speed: float, shock: float, pressure: float, density: float
) -> None:
    copper = materials.load("copper-ofhc")
    found = shocks(copper, copper, speed)
    assert math.isclose(found.interface, 0.5 * speed, rel_tol=ROUND_OFF)
    assert math.isclose(found.pressure, pressure, rel_tol=1e-4)
    for side in range(2):
        assert math.isclose(found.speeds[side], shock, rel_tol=1e-4)
        assert math.isclose(found.densities[side], density, rel_tol=1e-4)


def test_plates__end_before_any_shock_has_crossed_its_plate() -> None:
    run = asked("plate_impact", flyer="al-2024-t3", target_thickness=3e-3)
    problem = built(run).problem
    used = materials_of(run)
    found = shocks(used["flyer"], used["target"], 2000.0)
    crossed = [us * problem.end_time / l for us, l in zip(found.speeds, (4e-3, 3e-3), strict=True)]
    assert math.isclose(max(crossed), CROSSED, rel_tol=1e-9)
