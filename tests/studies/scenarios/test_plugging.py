"""Methods of a plugging: the coupled plate, what is measured of it, what is refused, and identities."""

import numpy as np
import pytest

from solver.problem import Smoothing
from solver.simulation import start
from solver.sph.smoothing import CubicSpline
from solver.state import Snapshot
from studies.measurements.plug import PlugView, view
from studies.runs.run import estimate
from studies.scenarios import Setting
from studies.sweeps.sweep import Sweep
from tests.contracts.test_scenarios import asked, built

COUPLED = {"geometry": "quarter", "method": "sph-fem", "plate_radius": 40e-3, "gap": 3e-3}
STEEL, WIDTH, THICKNESS, SPACING = 7850.0, 40e-3, 12e-3, 2e-3  # of the plate and its particles
ROUND_OFF = 1e-12


@pytest.fixture(scope="module")
def coupled() -> tuple[Setting, Snapshot]:
    """A coupled plugging at its start."""
    setting = built(asked("plugging", **COUPLED))
    return setting, start(setting.problem, threads=1).snapshot()


def seen(setting: Setting, snapshot: Snapshot, **changes: np.ndarray) -> PlugView:
    """The view of a snapshot with other arrays of its particles."""
    particles = snapshot.particles._replace(**changes)
    return view(setting, snapshot._replace(particles=particles))


def test_coupled_plate__has_the_mass_of_the_plate_and_meets_itself_on_nodes(coupled: tuple[Setting, Snapshot]) -> None:
    elements, _, particles = coupled[0].problem.bodies
    whole = STEEL * WIDTH**2 * THICKNESS
    assert elements.mass.sum() + particles.mass.sum() == pytest.approx(whole, rel=ROUND_OFF)
    nodes = {tuple(place) for place in elements.position}
    shared = [tuple(place) for place in particles.position if tuple(place) in nodes]
    assert len(shared) == (2 * 10 + 1) * 7
    assert all(max(x, y) == 20e-3 for x, y, _ in shared)


def test_coupled_plate__has_rings_as_wide_as_a_spacing_beside_its_particles(coupled: tuple[Setting, Snapshot]) -> None:
    position = coupled[0].problem.bodies[0].position
    widths = np.diff(np.unique(position[position[:, 1] == 0.0, 0]))
    assert widths[:3] == pytest.approx(SPACING, rel=1e-9)
    assert widths[4:] / widths[3:-1] == pytest.approx(1.25, rel=1e-9)


def test_coupled_plate__has_no_rings_wider_than_it_is_thick() -> None:
    setting = built(asked("plugging", **{**COUPLED, "plate_radius": 200e-3}))
    position = setting.problem.bodies[0].position
    widths = np.diff(np.unique(position[position[:, 1] == 0.0, 0]))
    assert widths[-1] == pytest.approx(THICKNESS, rel=0.1)
    assert widths.sum() == pytest.approx(180e-3)


def test_coupled_plate__is_held_at_its_rim_alone(coupled: tuple[Setting, Snapshot]) -> None:
    setting = coupled[0]
    simulation = start(setting.problem, threads=1)
    held = simulation.stepper.elements.held.all(axis=1)  # type: ignore[attr-defined]
    position = setting.problem.bodies[0].position
    np.testing.assert_array_equal(held, np.isclose(position[:, :2].max(axis=1), WIDTH))


def test_view_of_a_coupled_plate__is_attached_through_its_elements(coupled: tuple[Setting, Snapshot]) -> None:
    whole = seen(*coupled)
    assert whole.attached[~whole.projectile].all()
    assert not whole.has_plug
    assert whole.mass[~whole.projectile].sum() == pytest.approx(4.0 * STEEL * WIDTH**2 * THICKNESS)


def test_view_of_a_coupled_plate__sees_a_plug_behind_failed_particles(coupled: tuple[Setting, Snapshot]) -> None:
    setting, snapshot = coupled
    particles = snapshot.particles
    radius = np.hypot(particles.position[:, 0], particles.position[:, 1])
    plate = snapshot.body != 1
    damage = particles.damage.copy()
    damage[plate & (radius > 9e-3) & (radius < 14e-3)] = 1.0
    cut = seen(setting, snapshot, damage=damage)
    inside = plate & (radius <= 9e-3)
    assert cut.has_plug
    np.testing.assert_array_equal(cut.core, inside)
    np.testing.assert_array_equal(cut.attached, plate & (radius >= 14e-3))


def test_view_of_a_coupled_plate__lets_go_where_its_elements_fail(coupled: tuple[Setting, Snapshot]) -> None:
    setting, snapshot = coupled
    particles = snapshot.particles
    far = particles.position[:, :2].max(axis=1)
    damage = particles.damage.copy()
    torn = (snapshot.body == 0) & (far > 26e-3) & (far < 32e-3)
    assert torn.any()
    damage[torn] = 1.0
    loose = seen(setting, snapshot, damage=damage)
    assert not loose.attached[(snapshot.body != 1) & (far < 26e-3)].any()
    assert loose.attached[far > 39e-3].all()


def test_plugging__is_computed_by_each_method() -> None:
    for method, bodies in (("mpm", 2), ("sph", 2), ("sph-fem", 3)):
        setting = built(asked("plugging", **{**COUPLED, "method": method}))
        assert len(setting.problem.bodies) == bodies
        assert (setting.problem.smoothing is not None) == (method != "mpm")
        assert (setting.problem.contact is None) == (method != "mpm")


def test_coupled_plate__has_the_viscosity_of_a_grid_and_particles_that_repel(coupled: tuple[Setting, Snapshot]) -> None:
    problem = coupled[0].problem
    viscosity = built(asked("plugging")).problem.viscosity
    assert problem.viscosity == viscosity
    assert problem.smoothing == Smoothing(CubicSpline(), viscosity=viscosity, stiffness=0.01)


def test_coupled_plate__is_one_solid_and_the_projectile_another(coupled: tuple[Setting, Snapshot]) -> None:
    stepper = start(coupled[0].problem, threads=1).stepper
    elements, projectile, particles = stepper.particles.solids  # type: ignore[attr-defined]
    assert elements == particles != projectile


def test_estimate__counts_particles_and_nodes() -> None:
    run = asked("plugging", **COUPLED)
    real = sum(body.mass.size for body in built(run).problem.bodies)
    assert estimate(run).particles == pytest.approx(real, rel=0.02)


def test_search_for_a_limit__takes_a_method_as_any_parameter() -> None:
    sweep = Sweep.parse(
        {
            "scenario": "plugging",
            "fixed": {"geometry": "quarter", "method": "sph-fem", "gap": "3 mm"},
            "axes": {"speed": {"limit_of": "perforated", "between": ["100 m/s", "200 m/s"]}},
            "resolution": 10,
        }
    )
    runs = [point.run for point in sweep.runs()]
    assert {run.parameters["speed"] for run in runs} == {100.0, 150.0, 200.0}
    assert all(run.parameters["contact"] == "repulsion" for run in runs)
    assert all(len(built(run).problem.bodies) == 3 for run in runs[:1])
