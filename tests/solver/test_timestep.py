"""The step is the smallest of what each term asks for, and grows slowly."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.problem import ArtificialViscosity, Problem, StepRule
from solver.simulation import Simulation, start
from solver.steps.points import Tally, summarise
from solver.steps.timestep import FIRST_STEP, GROWTH, VOLUME_CHANGE, stable_step
from tests.solver.bodies import DENSITY, OPEN, ROUND_OFF, SHEAR_MODULUS, SOUND_SPEED, SPACING, block, box, two_blocks

COURANT, TRAVEL = 0.4, 0.5
BLOCKS = two_blocks("axisymmetric", courant=COURANT, travel=TRAVEL)
signals = st.floats(10.0, 1e6)
volume_rates = st.floats(0.0, 1e12)


def tally(*signals_and_rates: tuple[float, float], speed: float = 0.0) -> Tally:
    """What a step reports whose shares reported this of particles that fly at a speed."""
    rows = np.zeros((len(signals_and_rates), len(Tally._fields)))
    for row, (signal, rate) in enumerate(signals_and_rates):
        rows[row, :4] = signal, signal + speed, speed, rate
    summary = np.zeros(len(Tally._fields))
    summarise(rows, summary)
    return Tally(*summary.tolist())


def step(reported: Tally, previous: float = 1.0, rule: StepRule = StepRule.CONVECTIVE) -> float:
    return stable_step(replace(BLOCKS, step_rule=rule), reported, previous)


@given(signals, signals, volume_rates, st.floats(1e-12, 1e-3), st.sampled_from(StepRule))
def test_step__keeps_signals_particles_volumes_and_growth_within_their_parts(
    signal: float, speed: float, rate: float, previous: float, rule: StepRule
) -> None:
    dt = step(tally((signal, rate), speed=speed), previous, rule)
    assert dt > 0.0
    assert dt * (signal + speed * (rule == StepRule.CONVECTIVE)) <= COURANT * SPACING * (1.0 + ROUND_OFF)
    assert dt * speed <= TRAVEL * SPACING * (1.0 + ROUND_OFF)
    assert dt * rate <= VOLUME_CHANGE * (1.0 + ROUND_OFF)
    assert dt <= GROWTH * previous


def test_acoustic_step__does_not_fall_with_a_speed_that_travel_allows() -> None:
    slow, fast = (tally((6e3, 0.0), speed=speed) for speed in (0.0, 6e3))
    assert step(fast, rule=StepRule.ACOUSTIC) == step(slow, rule=StepRule.ACOUSTIC)
    assert step(fast) == pytest.approx(0.5 * step(slow))


def longitudinal_speed() -> float:
    """sqrt(c0^2 + 4/3 G / rho)."""
    return math.sqrt(SOUND_SPEED**2 + 4.0 / 3.0 * SHEAR_MODULUS / DENSITY)


def lone(speed: float = 0.0, **changes: Any) -> Simulation:
    geometry = box(6, 6, 6)
    body = block(geometry, (2.0, 2.0, 2.0), (4.0, 4.0, 4.0), velocity=(0.0, 0.0, speed))
    return start(Problem(geometry, (body,), OPEN, end_time=1e-6, **changes), threads=1)


@pytest.mark.parametrize("speed", [0.0, 6000.0])
def test_signal__is_sound_and_beside_it_the_particle_speed_on_top(speed: float) -> None:
    simulation = lone(speed, viscosity=ArtificialViscosity(0.0, 0.0))
    simulation.advance()
    expected = (longitudinal_speed(), longitudinal_speed() + speed, speed)
    assert simulation.tally[:3] == pytest.approx(expected, rel=1e-9)


def test_simulation__begins_with_a_tenth_of_the_step_and_grows_to_it() -> None:
    simulation = lone()
    stable = COURANT * SPACING / longitudinal_speed()
    steps = [simulation.dt]
    for _ in range(60):
        simulation.advance()
        steps.append(simulation.dt)
    assert steps[0] == pytest.approx(FIRST_STEP * stable, rel=1e-9)
    growth = np.array(steps[1:]) / np.array(steps[:-1])
    assert growth.max() <= GROWTH * (1.0 + ROUND_OFF)
    assert steps[-1] == pytest.approx(stable, rel=1e-6)
