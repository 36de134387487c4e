"""The stable step: the smallest of what each term asks for.

The grid is new in each step, so a step is Lagrangian: what it must not outrun are the waves through the matter, at the
sound speed with the viscosity's part (stress.py). The largest frequency of a grid of cells h decides, dt < 2 / omega.
For quadratic B-splines with lumped masses the stiffness (-1/6, -1/3, 1, -1/3, -1/6) / h gives omega = 1.15 c / h
along one axis and at most 2 c / h along three, where nodes are full; at a free surface, with a particle that only just
reaches a node, weight and slope of that node vanish as e^2 / 2 and e / h, which leaves omega = 1.41 c / h. So
dt < h / c is stable. Linear shapes have omega = 2 c / h where nodes are full, and no bound where a particle only just
reaches a node.

That a particle moves is no wave: the convective rule, |v| + c, is that of a fixed grid. What it protects is that
weights change little within a step, and that no particle jumps over the ghosts at a face: ``travel`` says so by itself.
"""

import math

import numpy as np

from solver.matter.eos import reference_density, reference_sound_speed
from solver.problem import Problem, StepRule
from solver.state import VX, VZ
from solver.steps.points import Tally

VOLUME_CHANGE = 0.1  # largest |tr D| dt: beyond it the midpoint work of a step loses its meaning
GROWTH = 1.05  # largest ratio of a step to the one before
FIRST_STEP = 0.1  # of the stable step, while the impact establishes itself


def stable_step(problem: Problem, tally: Tally, previous: float) -> float:
    """Signals cross at most ``courant`` of a cell, particles ``travel``, volumes change by at most a tenth; s.

    Steps grow slowly.
    """
    spacing = problem.geometry.spacing
    signal = tally.convected if problem.step_rule == StepRule.CONVECTIVE else tally.signal
    acoustic = problem.courant * spacing / signal
    moved = problem.travel * spacing / max(tally.speed, 1e-300)
    volumetric = VOLUME_CHANGE / tally.volume_rate if tally.volume_rate > 0.0 else acoustic
    return min(acoustic, moved, volumetric, GROWTH * previous)


def first_step(problem: Problem) -> float:
    """A cautious first step from the fastest signal of the initial state; s."""
    return FIRST_STEP * problem.courant * problem.geometry.spacing / _fastest_signal(problem)


def joining_step(problem: Problem) -> float:
    """The longest step with which particles join whose speed no step has seen yet; s."""
    return problem.courant * problem.geometry.spacing / _fastest_signal(problem)


def _fastest_signal(problem: Problem) -> float:
    """Sound on top of speed, of the initial state; m/s."""
    sound = max(
        math.sqrt(
            reference_sound_speed(body.matter.eos) ** 2
            + 4.0 / 3.0 * body.matter.shear_modulus / reference_density(body.matter.eos)
        )
        for body in problem.bodies
    )
    return sound + fastest(problem)


def fastest(problem: Problem) -> float:
    """Largest initial speed of any particle, those that are still to arrive included, m/s."""
    speeds = [float(np.sqrt((np.asarray(body.velocity) ** 2).sum(axis=-1)).max()) for body in problem.bodies]
    if problem.arrivals is not None:
        velocity = problem.arrivals.table[VX : VZ + 1]
        speeds.append(float(np.sqrt((velocity**2).sum(axis=0)).max(initial=0.0)))
    return max(speeds)
