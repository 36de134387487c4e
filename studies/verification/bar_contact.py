"""A bar hits a wall that does not pull, stays for the way there and back of a wave, and leaves."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from solver.simulation import start
from studies.values.recipes import Recipe
from studies.verification import Case, Row, at_least, at_most, relative, reported
from studies.verification._column import Stretch, column
from studies.verification._matter import elastic
from studies.verification._waves import Isotropic

SPEED = 3.0  # m/s
BAR = Isotropic(8930.0, 117e9, 0.0)  # copper's stiffness: Ma (2005), Table 2.1; no Poisson's effect
CELLS, SPACING = 40, 1e-3  # of the bar
VOID_CELLS = 10
END = 2.0  # of the time in contact

# Set before any run.
CONTACT_TIME, REBOUND = 0.03, 0.93
NO_PULL = 1e-10  # round-off of the difference of two impulses


@dataclass(frozen=True)
class Touch:
    """The push of the wall in each step."""

    time: np.ndarray  # at the end of each step, s
    force: np.ndarray  # mean over each step, N
    rebound: float  # momentum at the end over minus the one at the start


def contact_and_rebound(recipe: Recipe) -> tuple[float, float]:
    """Relative error of the time in contact, and the momentum after the rebound (of that before)."""
    touch = _touch(recipe)
    exact = 2.0 * CELLS * SPACING / BAR.bar_speed
    level = 0.5 * BAR.density * BAR.bar_speed * SPEED * SPACING**2
    return _duration(touch, level) / exact - 1.0, touch.rebound


def _run(recipe: Recipe) -> Iterator[Row]:
    touch = _touch(recipe)
    plateau = BAR.density * BAR.bar_speed * SPEED * SPACING**2
    held = touch.force >= 0.5 * plateau
    duration = _duration(touch, 0.5 * plateau)
    length = CELLS * SPACING
    yield relative(
        f"time in contact, force above half of rho c v, {CELLS} cells (us)",
        expected=2e6 * length / BAR.bar_speed,
        got=1e6 * duration,
        within=CONTACT_TIME,
    )
    yield at_least("momentum after the rebound (of that before)", limit=REBOUND, got=touch.rebound)
    pull = -float(touch.force.min()) / plateau
    yield at_most("largest pull of the wall (of rho c v A)", limit=NO_PULL, got=pull)
    yield reported("mean force while held (of rho c v A)", float(touch.force[held].mean()) / plateau)


def _touch(recipe: Recipe) -> Touch:
    length = CELLS * SPACING
    problem = column(
        [Stretch("bar", elastic(BAR), BAR.density, 0.0, length, -SPEED)],
        recipe,
        cells=CELLS + VOID_CELLS,
        spacing=SPACING,
        end_time=END * 2.0 * length / BAR.bar_speed,
        ends=("WALL", "FREE"),
    )
    simulation = start(problem, threads=1)
    times, impulses = [0.0], [0.0]
    while simulation.time < problem.end_time:
        simulation.advance()
        times.append(simulation.time)
        impulses.append(float(simulation.impulse[0]))
    particles = simulation.particles
    after = float((particles.mass * particles.velocity[:, 0]).sum())
    before = SPEED * float(particles.mass.sum())
    return Touch(np.array(times[1:]), np.diff(impulses) / np.diff(times), after / before)


def _duration(touch: Touch, level: float) -> float:
    """From the first to the last crossing of a level, each placed within its step by the means on both sides."""
    above = np.flatnonzero(touch.force >= level)
    if not above.size:
        return float("nan")
    first, last = int(above[0]), int(above[-1])
    steps = np.diff(touch.time, prepend=0.0)
    middle = touch.time - 0.5 * steps

    def crossing(low: int, high: int) -> float:
        share = (level - touch.force[low]) / (touch.force[high] - touch.force[low])
        return float(middle[low] + share * (middle[high] - middle[low]))

    begin = crossing(first - 1, first) if first else 0.0
    end = crossing(last + 1, last) if last + 1 < touch.time.size else float(touch.time[-1])
    return end - begin


CASE = Case(
    name="bar-contact",
    says="a bar stays at the wall for 2 L / c within 3 %, leaves with 0.93 of its momentum, and is never pulled",
    source="d'Alembert: rho c v for 2 L / c, then free flight; Ma (2005), section 2.3.1, for the problem",
    run=_run,
)
