"""What a step does to points beside their contracts: the energy that is stored, the first state, what is counted."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from solver.matter.eos.mie_grueneisen import MieGrueneisen
from solver.matter.laws import Matter
from solver.matter.stress import PointState, advance
from solver.matter.tensor import contract
from solver.problem import ArtificialViscosity, Problem
from solver.simulation import COUNTED, Simulation, start
from tests.solver.bodies import ABOUT_AXIS, DENSITY, MELT, ROOM, SPACING, block, box, elastic_copper, real_copper

DT = 1e-9


def cube(matter: Matter, density: float = 1.0, **changes: Any) -> Simulation:
    """Particles at rest in the middle of an open box, at a share of their density."""
    geometry = box(6, 6)
    body = block(geometry, (2.0, 2.0), (4.0, 4.0), matter=matter)
    body = replace(body, density=density * DENSITY, mass=density * body.mass, **changes)
    problem = Problem(geometry, (body,), ABOUT_AXIS, end_time=1e-6, fixed_dt=DT)
    return start(problem, threads=1)


def counted(simulation: Simulation) -> dict[str, int]:
    """The safeguards that one step counts, each of them a number of particles."""
    simulation.advance()
    counts = {name: getattr(simulation.counters, name) for name in COUNTED}
    return {name: count for name, count in counts.items() if count}


def test_energy_to_come__has_the_half_of_the_new_stress_on_top() -> None:
    """What scheme USF stores: (s : e - p tr - q tr) / 2 rho of the new stress, in the midpoint volume for p and q."""
    gradient = np.array([[-4e6, 1e6, 0.0], [3e6, 1e6, 0.0], [0.0, 0.0, 0.5e6]])
    stress = (3e7, -1e7, -2e7, 1e7, 0.0, 0.0)
    old = PointState(DENSITY, 100.0, 1e9, 0.0, stress, 0.1, ROOM)
    viscosity = ArtificialViscosity()
    new, present, _ = advance(real_copper(), viscosity, SPACING, DT, gradient, old)
    strain = 0.5 * (gradient + gradient.T) * DT
    shape = strain - np.trace(strain) / 3.0 * np.eye(3)
    shear = contract(new.deviator, (shape[0, 0], shape[1, 1], shape[2, 2], shape[0, 1], shape[1, 2], shape[2, 0]))
    opening = 1.0 / new.density - 1.0 / old.density
    work = 0.5 * shear / old.density - 0.5 * (new.pressure + new.viscosity) * opening
    assert math.isclose(present - new.energy, work, rel_tol=1e-9)


REAL = real_copper().eos
assert isinstance(REAL, MieGrueneisen)
TANGENT = 1.0 + REAL.mu_tangent  # times the density


@pytest.mark.parametrize(
    ("matter", "density", "state", "expected"),
    [
        (real_copper(), 1.0, {}, set()),
        (real_copper(), 1.0, {"temperature": MELT - 1.0}, set()),
        (real_copper(), 1.0, {"temperature": MELT}, {"molten"}),
        (real_copper(), 1.0, {"temperature": 2.0 * MELT}, {"molten"}),
        # Cold, c^2 = c0^2 (1 - gamma0 (rho0 - rho) / rho): far below zero at a hundredth of the density.
        (elastic_copper(), 0.9, {}, set()),
        (elastic_copper(), 0.01, {}, {"sound_floors", "unstable", "below_zero_kelvin"}),
        # c^2 = c0^2 + gamma0 p / rho0 without energy and in expansion: below zero from -70 GPa on.
        (elastic_copper(), 1.0 - 1e-9, {"pressure": -1e9}, set()),
        (elastic_copper(), 1.0 - 1e-9, {"pressure": -1e11}, {"unstable"}),
        (real_copper(), 1.0, {"density": 0.99 * TANGENT * DENSITY}, {"below_zero_kelvin"}),
        (real_copper(), 1.0, {"density": 1.01 * TANGENT * DENSITY}, {"below_zero_kelvin", "beyond_hugoniot"}),
        (real_copper(), 1.0, {"density": 0.9 * DENSITY}, {"tension_floors"}),
        (real_copper(), 1.0, {"energy": -3e5}, {"below_zero_kelvin", "tension_floors"}),
    ],
)
def test_counters__count_each_particle_on_which_a_safeguard_acts(
    matter: Matter, density: float, state: Mapping[str, float], expected: set[str]
) -> None:
    """All of the particles or none; the temperature of the cold ones is 0 K."""
    simulation = cube(matter, density)
    for name, value in state.items():
        getattr(simulation.particles, name)[:] = value
    counts = counted(simulation)
    assert counts == dict.fromkeys(expected, simulation.particles.mass.size)
    if "below_zero_kelvin" in expected:
        assert not simulation.particles.temperature.any()
