"""The scenarios that ship, one by one: masses, places, sizes of the thesis, and what they refuse."""

import math

import numpy as np
import pytest

from solver.geometry import impact_axis
from solver.problem import Face
from solver.simulation import start
from studies import materials, measurements, scenarios
from studies.runs.run import Run, materials_of, resolve
from studies.scenarios import ImpactSetting
from studies.scenarios.plate_impact import CROSSED, PlateSetting, shocks
from studies.values.errors import InvalidInput
from tests.contracts.test_scenarios import BARS, CORNERS, DIAMETER, ROUND_OFF, asked, built

# Impacts


@pytest.fixture(scope="module", params=CORNERS, ids=lambda corner: "-".join(map(str, (corner[0], *corner[1].values()))))
def run(request: pytest.FixtureRequest) -> Run:
    name, changes = request.param
    return asked(name, **changes)


@pytest.fixture(scope="module")
def setting(run: Run) -> ImpactSetting:
    setting = built(run)
    assert isinstance(setting, ImpactSetting)
    return setting


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
    assert math.isclose(target.mass.sum(), target.density * face * setting.thickness, rel_tol=ROUND_OFF)


def test_build__puts_the_projectile_in_front_of_the_target(run: Run, setting: ImpactSetting) -> None:
    axis = impact_axis(setting.problem.geometry)
    projectile, target = setting.problem.bodies
    assert projectile.position[:, axis].max() < 0.0 < target.position[:, axis].min()
    assert target.position[:, axis].max() < setting.thickness
    assert np.flatnonzero(projectile.velocity).tolist() == [axis]
    assert projectile.velocity[axis] == run.parameters["speed"]
    assert not target.velocity.any()


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
    view = scenario.observer.view(setting, start(setting.problem, threads=1).snapshot())
    for name, size in (("final_length", 11.1e-3), ("mushroom_diameter", DIAMETER), ("width_at_fifth", DIAMETER)):
        assert math.isclose(measurements.load(name).read(view).value, size, rel_tol=1e-9)


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
def test_plates__layers_are_counted_from_where_they_meet(geometry: str) -> None:
    setting = built(asked("plate_impact", geometry=geometry))
    assert isinstance(setting, PlateSetting)
    axis = impact_axis(setting.problem.geometry)
    place = np.concatenate([plate.position[:, axis] for plate in setting.problem.bodies])
    width = setting.problem.bodies[0].spacing[axis]
    assert np.allclose(np.abs(place), (setting.layer + 0.5) * width)


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
    result = shocks(copper, copper, speed)
    assert math.isclose(result.interface, 0.5 * speed, rel_tol=ROUND_OFF)
    assert math.isclose(result.pressure, pressure, rel_tol=1e-4)
    for side in range(2):
        assert math.isclose(result.speeds[side], shock, rel_tol=1e-4)
        assert math.isclose(result.densities[side], density, rel_tol=1e-4)


def test_plates__end_before_any_shock_has_crossed_its_plate() -> None:
    run = asked("plate_impact", flyer="al-2024-t3", target_thickness=3e-3)
    problem = built(run).problem
    used = materials_of(run)
    result = shocks(used["flyer"], used["target"], 2000.0)
    crossed = [us * problem.end_time / l for us, l in zip(result.speeds, (4e-3, 3e-3), strict=True)]
    assert math.isclose(max(crossed), CROSSED, rel_tol=1e-9)
