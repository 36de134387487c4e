"""How the cases compare two runs: a difference of one value of one particle shows, whatever it is."""

import numpy as np
import pytest

from solver.state import Particles, empty_table, views
from studies.cases.setups.impacts import image, largest_difference
from tests.solver.bodies import DENSITY, ROOM, SPACING

SPEED = 4e3  # m/s
COMPARED = [name for name in Particles._fields if name != "number"]  # by which they are ordered


def state() -> Particles:
    """Three particles with something in every field."""
    particles = views(empty_table(3))
    rng = np.random.default_rng(1)
    for name in ("position", "velocity", "energy", "pressure", "viscosity", "deviator", "damage"):
        field = getattr(particles, name)
        field[:] = rng.random(field.shape)
    particles.mass[:], particles.density[:], particles.temperature[:] = 1e-6, DENSITY, ROOM
    return particles


def changed(name: str, component: tuple[int, ...]) -> Particles:
    """The state with another value of the last particle."""
    particles = state()
    getattr(particles, name)[-1, *component] = 0 if name == "alive" else 2.0
    return particles


@pytest.mark.parametrize(
    ("name", "component"),
    [(name, component) for name in COMPARED for component in np.ndindex(getattr(state(), name).shape[1:])],
)
def test_largest_difference__sees_every_value_that_a_particle_carries(name: str, component: tuple[int, ...]) -> None:
    assert largest_difference(state(), changed(name, component), spacing=SPACING, speed=SPEED) > 1e-15


def test_largest_difference__of_a_state_to_itself_is_none() -> None:
    assert largest_difference(state(), state(), spacing=SPACING, speed=SPEED) == 0.0


@pytest.mark.parametrize("name", ["position", "energy", "temperature", "deviator"])
def test_largest_difference__of_what_is_no_number_is_none(name: str) -> None:
    broken = state()
    getattr(broken, name)[0] = np.nan
    assert np.isnan(largest_difference(state(), broken, spacing=SPACING, speed=SPEED))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_image__negates_what_names_its_axis_once(axis: int) -> None:
    before, after = state(), image(state(), axis)
    mirror = np.diag(np.where(np.arange(3) == axis, -1.0, 1.0))
    assert (after.position == before.position @ mirror).all()
    assert (after.velocity == before.velocity @ mirror).all()
    for first, second in zip(before.deviator, after.deviator, strict=True):
        assert (tensor(second) == mirror @ tensor(first) @ mirror).all()


def tensor(a: np.ndarray) -> np.ndarray:
    """Components 11 22 33 12 23 31 as a matrix."""
    return np.array([[a[0], a[3], a[5]], [a[3], a[1], a[4]], [a[5], a[4], a[2]]])
