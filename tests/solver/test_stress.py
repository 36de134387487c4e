"""What a step does to points beside their contracts: the energy that is stored, the first state, what is counted."""

import math
from typing import Any

import numpy as np
import pytest

from solver.eos.ideal_gas import IdealGas
from solver.eos.mie_grueneisen_cubic import mie_grueneisen_cubic
from solver.failure.plastic_strain import PlasticStrainLimit
from solver.problem import ArtificialViscosity, Body, Matter, Problem
from solver.simulation import COUNTED, Counters, Simulation, start
from solver.stress import PointState, advance
from solver.tensor import contract
from tests.solver.bodies import (
    CONSTANTS,
    DENSITY,
    MELT,
    OPEN,
    ROOM,
    SPACING,
    block,
    box,
    elastic_copper,
    real_copper,
)

DT = 1e-9
ROUND_OFF = 1e-12
# Safeguards rest on quiet matter.
QUIET = dict.fromkeys(COUNTED, 0)


def cube(matter: Matter, **changes: Any) -> Simulation:
    """Sixty-four particles at rest in the middle of an open box."""
    geometry = box(6, 6, 6)
    body = block(geometry, (2.0, 2.0, 2.0), (4.0, 4.0, 4.0), matter=matter)
    body = Body(**{**vars(body), **changes})
    problem = Problem(geometry, (body,), OPEN, end_time=1e-6, fixed_dt=DT)
    return start(problem, threads=1)


def counted(simulation: Simulation) -> dict[str, int]:
    """What one step counts, particle by particle."""
    simulation.advance()
    return {name: getattr(simulation.counters, name) for name in COUNTED}


def test_energy_to_come__has_the_half_of_the_new_stress_on_top() -> None:
    """What scheme USF stores: (s : e - p tr - q tr) / 2 rho of the new stress, in the midpoint volume for p and q."""
    gradient = np.array([[-4e6, 1e6, 0.0], [3e6, 1e6, 0.0], [0.0, 0.0, 0.5e6]])
    stress = (3e7, -1e7, -2e7, 1e7, 0.0, 0.0)
    old = PointState(DENSITY, 100.0, 1e9, 0.0, stress, 0.1, ROOM)
    viscosity = ArtificialViscosity()
    new, present, _ = advance(real_copper(), viscosity, SPACING, DT, gradient, old)
    strain = 0.5 * (gradient + gradient.T) * DT
    shape = strain - np.trace(strain) / 3.0 * np.eye(3)
    shear = contract(
        new.deviator,
        (shape[0, 0], shape[1, 1], shape[2, 2], shape[0, 1], shape[1, 2], shape[2, 0]),
    )
    opening = 1.0 / new.density - 1.0 / old.density
    work = 0.5 * shear / old.density - 0.5 * (new.pressure + new.viscosity) * opening
    assert math.isclose(present - new.energy, work, rel_tol=1e-9)


def test_start__of_a_cold_solid_has_no_pressure() -> None:
    particles = cube(real_copper()).particles
    assert not particles.pressure.any()
    assert not particles.energy.any()
    assert np.all(particles.temperature == ROOM)


def test_start__of_a_gas_has_the_pressure_of_its_energy() -> None:
    gas = elastic_copper()._replace(
        eos=IdealGas(
            density=DENSITY, sound_speed=1e3, gamma=1.4, heat_capacity=717.0, temperature=ROOM
        ),
        shear_modulus=0.0,
    )
    energy = 1e6 / (1.4 * 0.4)  # J/kg, of c = 1 km/s
    particles = cube(gas, energy=energy).particles
    assert particles.energy == pytest.approx(energy, rel=ROUND_OFF)
    assert particles.pressure == pytest.approx(0.4 * DENSITY * energy, rel=ROUND_OFF)
    assert particles.temperature == pytest.approx(ROOM, rel=ROUND_OFF)


def test_counters__know_every_safeguard_that_a_share_counts() -> None:
    assert set(COUNTED) == set(vars(Counters())) - {"reflected"}


def test_counters__stay_at_zero_where_no_safeguard_acts() -> None:
    assert counted(cube(real_copper())) == QUIET


@pytest.mark.parametrize(("kelvin", "share"), [(MELT - 1.0, 0), (MELT, 1), (2.0 * MELT, 1)])
def test_molten__counts_each_particle_at_or_above_the_melting_point(
    kelvin: float, share: int
) -> None:
    simulation = cube(real_copper())
    simulation.particles.temperature[:] = kelvin
    assert counted(simulation)["molten"] == share * simulation.particles.mass.size


@pytest.mark.parametrize(("share", "expected"), [(0.9, 0), (0.01, 1)])
def test_sound_floors__counts_each_particle_that_sets_its_signal_by_the_floor(
    share: float, expected: int
) -> None:
    """Cold, c^2 = c0^2 (1 - gamma0 (rho0 - rho) / rho): far below zero at a hundredth of the density."""
    simulation = cube(elastic_copper(), density=share * DENSITY)
    simulation.particles.mass[:] *= share
    assert counted(simulation)["sound_floors"] == expected * simulation.particles.mass.size


@pytest.mark.parametrize(("pressure", "expected"), [(-1e9, 0), (-1e11, 1)])
def test_unstable__counts_each_particle_whose_sound_is_imaginary_for_the_viscosity(
    pressure: float, expected: int
) -> None:
    """c^2 = c0^2 + gamma0 p / rho0 without energy and in expansion: below zero from -70 GPa on."""
    simulation = cube(elastic_copper(), density=(1.0 - 1e-9) * DENSITY)
    simulation.particles.pressure[:] = pressure
    assert counted(simulation)["unstable"] == expected * simulation.particles.mass.size


@pytest.mark.parametrize(("share", "expected"), [(0.51, 0), (0.49, 1)])
def test_below_expansion__counts_each_particle_thinner_than_the_cubic_form_goes(
    share: float, expected: int
) -> None:
    cubic = elastic_copper()._replace(eos=mie_grueneisen_cubic(**CONSTANTS))
    simulation = cube(cubic, density=share * DENSITY)
    simulation.particles.mass[:] *= share
    assert counted(simulation)["below_expansion"] == expected * simulation.particles.mass.size


def test_failed__counts_each_particle_once() -> None:
    simulation = cube(real_copper()._replace(failure=PlasticStrainLimit(0.5)))
    particles = simulation.particles
    particles.plastic_strain[:10] = 0.6
    particles.plastic_strain[10:20] = 0.4
    for _ in range(3):
        assert counted(simulation)["failed"] == 10
    assert (simulation.particles.damage == 1.0).sum() == 10
