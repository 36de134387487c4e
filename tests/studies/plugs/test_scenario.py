"""Methods of a plugging: the coupled plate, what is measured of it, what is refused, and identities."""

import numpy as np
import pytest

from solver.simulation import start
from solver.state import Snapshot
from solver.steppers import methods
from studies.plugs.plug import PlugView, view
from studies.scenarios.parts.impact import ImpactSetting
from tests.contracts.test_scenarios import asked, built
from tests.studies.plugs.samples import COUPLED

STEEL, WIDTH, THICKNESS, SPACING = 7850.0, 40e-3, 12e-3, 2e-3  # of the plate and its particles
ROUND_OFF = 1e-12
Coupled = tuple[ImpactSetting, Snapshot]


@pytest.fixture(scope="module")
def coupled() -> Coupled:
    if "sph-fem" not in methods():
        pytest.skip("no elements are there")
    setting = built(asked("plugging", **COUPLED))
    return setting, start(setting.problem, threads=1).snapshot()


def seen(setting: ImpactSetting, snapshot: Snapshot, **changes: np.ndarray) -> PlugView:
    particles = snapshot.particles._replace(**changes)
    return view(setting, snapshot._replace(particles=particles))


def test_coupled_plate__has_the_mass_of_the_plate_and_meets_itself_on_nodes(coupled: Coupled) -> None:
    elements, _, particles = coupled[0].problem.bodies
    whole = STEEL * WIDTH**2 * THICKNESS
    assert elements.mass.sum() + particles.mass.sum() == pytest.approx(whole, rel=ROUND_OFF)
    nodes = {tuple(place) for place in elements.position}
    shared = [tuple(place) for place in particles.position if tuple(place) in nodes]
    assert len(shared) == (2 * 10 + 1) * 7
    assert all(max(x, y) == 20e-3 for x, y, _ in shared)


def test_view_of_a_coupled_plate__is_attached_through_its_elements(coupled: Coupled) -> None:
    whole = seen(*coupled)
    assert whole.attached[~whole.projectile].all()
    assert not whole.has_plug
    assert whole.mass[~whole.projectile].sum() == pytest.approx(4.0 * STEEL * WIDTH**2 * THICKNESS)


def test_view_of_a_coupled_plate__sees_a_plug_behind_failed_particles(coupled: Coupled) -> None:
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


def test_view_of_a_plug__has_the_failed_matter_beside_it_that_flies_with_it() -> None:
    """A ring of failed matter stands about the core: the upper half of its inner cells flies along, and all beyond."""
    setting = built(asked("plugging"))
    snapshot = start(setting.problem).snapshot()
    particles, plate = snapshot.particles, snapshot.body == 1
    assert setting.target == setting.problem.bodies[1].name
    cell, lower = setting.problem.geometry.spacing, setting.problem.geometry.lower
    ring = np.floor((particles.position[:, 0] - lower[0]) / cell) - 8.0  # cells beyond the first eight
    upper = particles.position[:, 1] > particles.position[plate, 1].mean()
    beside = plate & (ring == 0.0)
    particles.damage[plate & (ring >= 0.0) & (ring <= 2.0)] = 1.0
    particles.velocity[plate & (ring <= 2.0), 1] = 100.0
    particles.velocity[beside & ~upper, 1] = 40.0
    state = view(setting, snapshot)
    np.testing.assert_array_equal(state.core, plate & (ring < 0.0))
    np.testing.assert_array_equal(state.plug, state.core | (beside & upper))
