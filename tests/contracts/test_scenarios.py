"""Every scenario declares its parameters, builds at its corners, starts in balance and is estimated."""

import itertools
import math
from functools import cache
from typing import Any

import numpy as np
import pytest

from solver.simulation import start
from studies import measurements, scenarios
from studies.quantities.parameters import declared
from studies.runs.run import Run, resolve
from studies.scenarios import Scenario, Setting, SetUp
from tests import samples
from tests.claims.marked import claimed
from tests.samples import ANY, CYLINDER, DIAMETER, SHOT
from tests.solver.bodies import after

ROUND_OFF = 1e-12
MOMENTUM, ENERGY = 1e-10, 0.01  # what ten steps may lose, of the initial values
ESTIMATE = 3.0  # factor within which the estimated number of particles must lie

# A scenario's own parameters, small; a new scenario brings its own, that of a feature in its samples.
OWN: dict[str, dict[str, Any]] = {
    "thin_plate": {**SHOT, "plate_thickness": 4e-3, "plate_radius": 1.5 * DIAMETER},
    "thick_plate": {**SHOT, "target_depth": 1.5 * DIAMETER, "target_radius": 1.5 * DIAMETER},
}
SMALL = samples.joined("SMALL", OWN)
# Parameter that sets the resolution of a grid, and the extent that has that many cells.
RESOLUTION = samples.joined("RESOLUTION", {})
# Axes along which a finer grid has more particles, where they are not two: a column of plates stays one cell wide.
DIMENSIONS = samples.joined("DIMENSIONS", {})
IMPACTS = ("thick_plate", "thin_plate")
GEOMETRIES = ("axisymmetric", "quarter", "half")
EDGES = ("fixed", "free")
Changes = dict[str, Any]
CORNERS: tuple[tuple[str, Changes], ...] = tuple(
    (name, {"geometry": geometry, "projectile_shape": "sphere", "edges": edges, **shape})
    for name, geometry, shape, edges in itertools.product(IMPACTS, GEOMETRIES, ({}, CYLINDER), EDGES)
)
OBLIQUE: Changes = {"geometry": "half", **CYLINDER, "obliquity": math.radians(40.0), "yaw": math.radians(-15.0)}
# Each is a corner by itself, of the small parameters; the far ends of what the fields allow among them.
VARIED: tuple[tuple[tuple[str, ...], tuple[Changes, ...]], ...] = (
    (tuple(OWN), ANY),
    (IMPACTS, ({"courant": 0.01},)),
    # The step does these alike whatever it was given: one scenario stands for all.
    (
        ("thin_plate",),
        (
            {"recipe": "thesis"},
            {"viscosity_linear": 0.0, "viscosity_quadratic": 0.0},
            {"fixed_dt": 1e-9},
            {"scheme": "usf"},
            {"scheme": "usl"},
            {"damping_rate": 1e5, "damping_order": 2},
        ),
    ),
    (("thick_plate",), ({"edges": "absorbing", "target_depth": 0.04, "target_radius": 0.04},)),
    (
        IMPACTS,
        (
            {"thermal_softening": False},
            {"speed": 100.0},
            {"speed": 20e3},
            {"cells_per_diameter": 2.0},
            {"cells_per_diameter": 64.0},
            {"offset": 0.5},
            {**CYLINDER, "projectile_length": 5.0 * DIAMETER},
            {"projectile": "al-2024-t3"},
            {"target": "al-2024-t3"},
            OBLIQUE,
        ),
    ),
    *itertools.chain(*samples.offered("VARIED")),
)
VARIATIONS = CORNERS + tuple(
    (name, change) for scenarios_of, changes in VARIED for name in scenarios_of for change in changes
)
# Laws, shapes and edges in sets that no other ordinary test computes with: to compile each takes two to six seconds
# (2026-11-25), so that these take their steps in the claim alone. Contracts of the laws have each of them by itself.
COMPILED_ALONE: tuple[tuple[str, Changes], ...] = (
    ("thin_plate", {"tension": "unlimited", "eos_form": "cubic", "failure": "plastic-strain", "failure_strain": 0.5}),
    ("thin_plate", {"shape": "gimp"}),
    ("thin_plate", {"edges": "absorbing", "geometry": "quarter"}),
    ("thin_plate", {"edges": "absorbing", "geometry": "half", "offset": 0.5, "shape": "gimp"}),
    *itertools.chain(*samples.offered("COMPILED_ALONE")),
)
EVERY = VARIATIONS + COMPILED_ALONE


def asked(scenario: str, **changes: Any) -> Run:
    """A run at low resolution."""
    return resolve(scenario, {**SMALL[scenario], **changes})


def given_of(run: Run) -> SetUp:
    return scenarios.load(run.scenario).record(run.parameters)


def built(run: Run) -> Any:
    return given_of(run).build(run.materials)


@pytest.fixture(params=scenarios.names())
def scenario(request: pytest.FixtureRequest) -> Scenario:
    return scenarios.load(request.param)


@cache
def variation(number: int) -> tuple[Run, Setting]:
    name, changes = EVERY[number]
    run = asked(name, **changes)
    return run, built(run)


def id_of(number: int) -> str:
    name, changes = EVERY[number]
    return "-".join([name, *(f"{name}-{str(value).splitlines()[0]}" for name, value in changes.items())])


@pytest.fixture(params=range(len(EVERY)), ids=id_of)
def varied(request: pytest.FixtureRequest) -> tuple[Run, Setting]:
    return variation(request.param)


def test_scenario__brings_small_parameters() -> None:
    assert set(SMALL) == set(scenarios.names()), "give each scenario its small parameters above"


def test_scenario__describes_itself(scenario: Scenario) -> None:
    assert scenario.title
    assert scenario.description.endswith(".")


def test_scenario__describes_every_parameter(scenario: Scenario) -> None:
    for parameter in declared(scenario.parameters).values():
        assert parameter.meaning
        if parameter.kind in ("quantity", "integer"):
            assert parameter.minimum is not None
            assert parameter.maximum is not None
            default = parameter.minimum if parameter.default is None else parameter.default
            assert parameter.minimum <= float(default) <= parameter.maximum
            assert parameter.minimum < parameter.maximum


def test_scenario__names_fields_measurements_and_materials_that_exist(scenario: Scenario) -> None:
    known = declared(scenario.parameters)
    assert all(known[name].kind == "material" for name in scenario.materials)
    assert set(scenario.measurements) <= set(measurements.names())
    assert set(scenario.settles) <= set(scenario.measurements)
    for one in scenario.measurements:
        assert set(measurements.load(one).follows) <= set(scenario.measurements)
    assert {*scenario.least_cells, *scenario.fewest_cells} <= set(given_of(asked(scenario.name)).cells())


def test_scenario__is_observed_often_enough_to_be_seen_growing(scenario: Scenario) -> None:
    run = asked(scenario.name)
    setting = built(run)
    rate = given_of(run).rate(setting)
    assert 0.0 < rate.interval < setting.problem.end_time
    assert bool(scenario.settles) == math.isfinite(rate.window)
    if scenario.settles:
        assert rate.interval < rate.window < setting.problem.end_time


def test_scenario__is_measured_at_its_start(scenario: Scenario) -> None:
    """Each measurement has a value or a reason before anything has happened."""
    setting = built(asked(scenario.name))
    view = scenario.parameters.view(setting, start(setting.problem, threads=1).snapshot())
    for one in scenario.measurements:
        measurement = measurements.load(one)
        if not measurement.follows:
            reading = measurement.read(view)
            assert math.isfinite(reading.value) or reading.flags
    assert all(math.isfinite(number) for number in scenario.parameters.numbers(view).values())


def test_scenario__says_how_well_it_is_resolved(scenario: Scenario) -> None:
    parameter, word = RESOLUTION.get(scenario.name, ("cells_per_diameter",) * 2)
    run = asked(scenario.name)
    cells = given_of(run).cells()
    assert set(cells) <= {"cells_per_diameter", "cells_per_thickness", "cells_per_wall", "refinement"}
    assert cells[word] == run.parameters[parameter]


@pytest.mark.parametrize(
    "varied", claimed(range(len(EVERY)), range(len(VARIATIONS)), "scenarios", "ten-steps"), ids=id_of, indirect=True
)
def test_variation__keeps_the_balance_over_ten_steps(varied: tuple[Run, Setting]) -> None:
    """Ten steps of a scenario keep mass, momentum and energy, with any of its laws, shapes and edges."""
    audit = after(varied[1].problem, 10).audit()
    assert audit.mass_error <= ROUND_OFF
    assert audit.momentum_error <= MOMENTUM
    assert abs(audit.energy_drift) <= ENERGY


def test_variation__gives_every_particle_a_mass_and_no_two_the_same_place(varied: tuple[Run, Setting]) -> None:
    for body in varied[1].problem.bodies:
        assert body.mass.min() > 0.0
        assert len(np.unique(body.position.round(9), axis=0)) == body.mass.size


def test_variation__is_estimated_near_its_real_number_of_particles(varied: tuple[Run, Setting]) -> None:
    run, setting = varied
    real = sum(body.mass.size for body in setting.problem.bodies)
    size = given_of(run).size(run.materials)
    assert real / ESTIMATE < size.particles < real * ESTIMATE


def test_estimate__grows_with_resolution(scenario: Scenario) -> None:
    parameter, _ = RESOLUTION.get(scenario.name, ("cells_per_diameter",) * 2)
    sizes = []
    for cells in (16.0, 32.0):
        given = asked(scenario.name, **{parameter: cells})
        sizes.append(given_of(given).size(given.materials))
    dimensions = DIMENSIONS.get(scenario.name, 2)
    assert math.isclose(sizes[1].particles / sizes[0].particles, 2.0**dimensions, rel_tol=0.01)
    assert math.isclose(sizes[1].steps / sizes[0].steps, 2.0, rel_tol=0.01)
