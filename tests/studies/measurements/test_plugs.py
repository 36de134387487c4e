"""What the measurements of a plugging read off states with a known answer."""

import math

import numpy as np
import pytest

from studies.measurements._plug import _flying_with, _pieces
from studies.values.results import DEFINITION
from tests.studies.measurements.plugs import (
    DISHED,
    FLYER,
    FRONT,
    PARTICLE,
    PUSHER,
    REAR,
    STEEL,
    THICKNESS,
    plugged,
    slowed,
)
from tests.studies.measurements.states import read, value

INTERVAL = 200e-6 / 160


def test_hole__has_the_radii_of_its_wall_at_both_faces() -> None:
    # An edge on a lattice is known to half a particle; a diameter has two of them.
    state = plugged()
    assert value("hole_diameter_front", state) == pytest.approx(2.0 * FRONT, abs=PARTICLE)
    assert value("hole_diameter_rear", state) == pytest.approx(2.0 * REAR, abs=PARTICLE)
    assert value("dishing", state) == pytest.approx(DISHED)


def test_plug__has_the_mass_and_velocity_of_its_cylinder() -> None:
    state = plugged()
    mass = read("plug_mass", state)
    cylinder = STEEL * math.pi * (0.5 * (FRONT + REAR)) ** 2 * THICKNESS
    assert mass.value == pytest.approx(cylinder, rel=PARTICLE / FRONT)
    # A tenth of the radius has failed: half of that ring is the part of the definition.
    assert mass.parts[DEFINITION] == pytest.approx(0.5 * 0.19 * cylinder, rel=0.1)
    assert value("plug_velocity", state) == pytest.approx(FLYER)
    assert read("plug_mass", plugged(free=False)).flags == ("no_plug",)


def test_perforated__asks_for_an_open_plate_and_a_projectile_that_goes_on() -> None:
    assert value("perforated", plugged()) == 1.0
    assert value("perforated", plugged(speed=-1.0)) == 0.0
    assert value("perforated", plugged(is_open=False, speed=9.0)) == 0.0
    # A plate that springs back may be faster than a projectile that rebounds.
    assert value("perforated", plugged(is_open=False, speed=-5.0, plate=-20.0)) == 0.0
    assert read("perforated", plugged(is_open=False, speed=11.0)).flags == ("undecided",)


def test_residual_velocity__is_that_of_the_end_or_nothing() -> None:
    assert value("residual_velocity", slowed(7e-6)) == pytest.approx(0.7 * PUSHER)
    assert value("residual_velocity", slowed(7e-6, perforated=0.0)) == 0.0
    assert read("residual_velocity", slowed(7e-6, perforated=math.nan)).flags == ("undecided",)
    assert read("residual_velocity", slowed(7e-6, end=110e-6)).flags == ("in_contact",)


@pytest.mark.parametrize("touch", [7.0e-6, 7.6e-6, 8.74e-6])
def test_first_contact__is_found_between_observations(touch: float) -> None:
    assert value("first_contact", slowed(touch)) == pytest.approx(touch, abs=1e-12)


def test_plug_separation__is_the_first_observation_with_a_plug_that_stays() -> None:
    assert value("plug_separation", slowed(7e-6)) == pytest.approx(120e-6, abs=INTERVAL)
    assert read("plug_separation", slowed(7e-6, freed=201e-6)).flags == ("no_plug",)


def test_failed_matter__joins_nothing_and_flies_with_the_plug() -> None:
    """A row of cells: plug, two failed particles of which one stays behind, plate up to its rim."""
    cell = np.stack([np.arange(8), np.zeros(8, int), np.zeros(8, int)], axis=1)
    whole = np.array([1, 1, 1, 0, 0, 1, 1, 1], bool)
    rim, mass = cell[:, 0] == 7, np.ones(8)
    attached, core = _pieces(cell, mass, whole, rim)
    assert np.flatnonzero(core).tolist() == [0, 1, 2]
    assert np.flatnonzero(attached).tolist() == [5, 6, 7]
    velocity = np.array([100.0, 100.0, 100.0, 60.0, 90.0, 0.0, 0.0, 0.0])
    assert np.flatnonzero(_flying_with(cell, mass, velocity, core, ~whole)).tolist() == [3]
    velocity[3] = 40.0
    assert not _flying_with(cell, mass, velocity, core, ~whole).any()
