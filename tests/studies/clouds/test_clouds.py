"""Debris clouds with a known answer, and the view of one in a real problem, in whatever order the particles come."""

import dataclasses
import math
from typing import Any

import numpy as np
import pytest

from solver.matter.eos import pressure_terms
from solver.matter.melting import residual_energy
from solver.simulation import start
from solver.state import Snapshot, records
from studies.clouds.cloud import SPEEDS as SPEEDS_OF_BINS
from studies.debris.cloud import view
from studies.measurements import distributions
from studies.quantities.measured import DEFINITION
from tests.contracts.test_scenarios import asked, built
from tests.studies.clouds.samples import BALLS, two_balls
from tests.studies.debris.made import CLOUD_SPEED, MELTING
from tests.studies.measurements.states import DENSITY, ROUND_OFF, read, value

MASSES = [float(two_balls().mass[two_balls().projectile == first].sum()) for first in (True, False)]
SPEEDS = [speed for _, _, speed in BALLS]


@pytest.mark.parametrize(("excess", "share"), [(-1e3, 0.0), (50e3, 0.25), (200e3, 1.0), (1e6, 1.0)])
def test_melted_share__follows_the_lever_rule(excess: float, share: float) -> None:
    """A half of the mass has the residual energy of melting and an excess (J/kg), the rest is cold."""
    state = two_balls()
    hot = MELTING.onset + excess
    state = dataclasses.replace(state, residual=np.where(state.projectile, hot, 0.0))
    assert value("melted_share_projectile", state) == pytest.approx(share, abs=ROUND_OFF)
    part = MASSES[0] / sum(MASSES)
    assert value("melted_share_behind", state) == pytest.approx(share * part, abs=ROUND_OFF)
    liquid = share if share == 1.0 else 0.0
    parts = read("melted_share_projectile", state).parts
    assert parts[DEFINITION] == pytest.approx(0.5 * (share - liquid), abs=ROUND_OFF)


def test_distribution__has_all_mass_outside_the_plate_in_the_bins_of_its_flight() -> None:
    mass = distributions.load("mass_over_velocity_and_angle").read(two_balls())
    expected = np.zeros_like(mass)
    for amount, speed in zip(MASSES, SPEEDS, strict=True):
        expected[int(speed / CLOUD_SPEED / SPEEDS_OF_BINS.width), 0] += amount
    np.testing.assert_allclose(mass, expected, rtol=ROUND_OFF)


# The view


@pytest.fixture(scope="module", params=["axisymmetric", "quarter", "half"])
def touching(request: pytest.FixtureRequest) -> tuple[Any, Snapshot]:
    """A projectile that touches its plate."""
    setting = built(asked("debris_cloud", geometry=request.param))
    return setting, start(setting.problem).snapshot()


def through(setting: Any, snapshot: Snapshot, time: float) -> Snapshot:
    """The projectile departed at the touch, and flown for a time (s)."""
    particles, gone = snapshot.particles, snapshot.body == 0
    departed = records(0.0, particles, snapshot.body, np.flatnonzero(gone))
    left = particles._replace(alive=(~gone).astype(np.uint8))
    return snapshot._replace(time=time, particles=left, departed=departed)


def test_view__counts_what_departed_where_it_has_flown(touching: tuple[Any, Snapshot]) -> None:
    setting, snapshot = touching
    diameter, flight = setting.projectile_diameter, 20.0 * setting.projectile_diameter
    state = view(setting, through(setting, snapshot, flight / setting.speed))
    mass = DENSITY * math.pi / 6.0 * diameter**3
    assert value("mass_behind", state) == pytest.approx(mass, rel=ROUND_OFF)
    assert value("momentum_behind", state) == pytest.approx(mass * setting.speed, rel=ROUND_OFF)
    # A tenth of the particles that a run needs, so that a hundredth of the mass is less than one of them.
    assert read("rear_velocity", state).value == pytest.approx(setting.speed, rel=ROUND_OFF)
    assert value("fragments", state) == 1.0
    assert value("largest_fragment", state) == pytest.approx(mass, rel=ROUND_OFF)
    length = read("cloud_length", state).value + setting.thickness
    assert flight - diameter < length < flight


def test_view__has_the_energy_that_is_left_once_matter_has_expanded(touching: tuple[Any, Snapshot]) -> None:
    """Of pressed matter on the grid less than it has, and all of it of what departed."""
    setting, snapshot = touching
    matter = setting.problem.bodies[0].matter
    particles, hot = snapshot.particles, 1e6  # J/kg
    density = np.full(particles.mass.size, 1.3 * matter.eos.density)
    cold, thermal = pressure_terms(matter.eos, density, hot)
    energy = np.full(particles.mass.size, hot)
    pressure = cold + thermal * hot
    pressed = snapshot._replace(particles=particles._replace(density=density, energy=energy, pressure=pressure))
    left = float(residual_energy(matter.eos, density[0], hot, pressure[0]))
    assert left < 0.9 * hot
    np.testing.assert_allclose(view(setting, pressed).residual, left, rtol=ROUND_OFF)
    gone = view(setting, through(setting, pressed, 0.0)).residual
    of_projectile = (pressed.body == 0).sum()
    np.testing.assert_allclose(gone[-of_projectile:], hot, rtol=ROUND_OFF)
    np.testing.assert_allclose(gone[:-of_projectile], left, rtol=ROUND_OFF)
