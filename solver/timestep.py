"""The stable step: the smallest of what each term asks for."""

from solver.stress import Tally

VOLUME_CHANGE = 0.1  # largest |tr D| dt: beyond it the midpoint work of a step loses its meaning
GROWTH = 1.05  # largest ratio of a step to the one before
FIRST_STEP = 0.1  # of the stable step, while the impact establishes itself


def stable_step(tally: Tally, *, courant: float, spacing: float, previous: float) -> float:
    """Signals cross at most ``courant`` of a cell, volumes change by at most a tenth, steps grow slowly; s."""
    acoustic = courant * spacing / float(tally.signal.max())
    fastest = float(tally.volume_rate.max())
    volumetric = VOLUME_CHANGE / fastest if fastest > 0.0 else acoustic
    return min(acoustic, volumetric, GROWTH * previous)


def first_step(fastest: float, *, courant: float, spacing: float) -> float:
    """A cautious first step from the fastest signal of the initial state (m/s); s."""
    return FIRST_STEP * courant * spacing / fastest
