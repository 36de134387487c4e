"""The interface of the methods that compute a step: what a simulation gives to a method, and gets from it."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from solver.errors import ProblemError
from solver.matter.eos import burns
from solver.problem import Problem, Scheme
from solver.state import Particles
from solver.steps.points import StateLimits, Tally
from solver.steps.threads import ThreadPool


class Partition(NamedTuple):
    """The particles of a step, cut into shares."""

    table: np.ndarray  # (ROWS, n)
    particles: Particles  # views of it
    shares: np.ndarray  # (s, bodies, 2) where each body's particles begin and end in each share


class StepBalance(NamedTuple):
    """Momentum and energy that a step exchanged with faces, damping and contact, and its tally."""

    # (3,) given by faces and absorbers, to nodes or in what damping does next to them, N s.
    impulse: np.ndarray
    energy: float  # removed by damping, walls and absorbers, J
    contact: float  # removed by contact between bodies, J
    work: float  # of tractions and gravity, J
    gone: int  # particles that left through free faces
    reflected: int  # particles put back at closed faces
    tally: Tally


class Method:
    """A way to compute steps; the particles are its whole state where it says nothing else."""

    def __init__(self, problem: Problem, limits: StateLimits, pool: ThreadPool, shares: int):
        """The steps of a problem; ``shares`` of its particles or elements may be done at once."""

    def advance(self, partition: Partition, time: float, dt: float) -> StepBalance:
        """Take the particles from n, at a time, to n+1."""
        raise NotImplementedError

    def material_points(self, particles: Particles, body: np.ndarray) -> tuple[Particles, np.ndarray]:
        """The points with a stress, and the index of each one's body."""
        return particles, body

    def show(self, table: np.ndarray) -> None:
        """Write the present state into the table (ROWS, n) of particles."""

    def carried(self) -> dict[str, np.ndarray]:
        """Arrays that pass from step to step beside the particles."""
        return {}

    def take_over(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from what ``carried`` gave."""


def refuse(problem: Problem, method: str, more: Mapping[str, bool]) -> None:
    """Raise ProblemError with what a method beside the grid does not compute, by name; ``more`` is its own."""
    refused = {
        **more,
        "another scheme than musl": problem.scheme != Scheme.MUSL,
        "damping (set its rate to 0)": problem.damping.rate > 0.0,
        "contact with fields of their own": problem.contact is not None,
        "retired debris (follow it)": problem.retirement is not None,
        "arrivals": problem.arrivals is not None,
        "absorbing surfaces (take free ones)": bool(problem.absorbers),
        "explosives": any(burns(body.matter.eos) for body in problem.bodies),
    }
    found = [name for name, is_there in refused.items() if is_there]
    if found:
        raise ProblemError(f"{method} do not compute {', '.join(found)}")
