"""Pressures on ends of bodies of smoothed particles: the outermost layer carries them, on the end's area as it is now.

The end is the layer that begins outermost, each of its particles with the area of its volume over its spacing along the
axis. It is taken to have widened evenly: by its standard deviations across the axis, over those at the start.
"""

from dataclasses import dataclass

import numpy as np

from solver.problem import Problem, Traction
from solver.state import X

WITHIN = 1e-6  # of a spacing: particles of one layer


@dataclass(frozen=True)
class PressedEnd:
    """The end of a body that a traction presses on."""

    load: Traction
    numbers: np.ndarray  # (k,) of its particles
    areas: np.ndarray  # (k,) at the start, m2 (m, or 1, in fewer dimensions)
    across: tuple[int, ...]  # axes in which it lies and has extent
    width: float  # product of its standard deviations along them at the start

    def forces(self, table: np.ndarray, columns: np.ndarray, areas: np.ndarray, pressure: float) -> np.ndarray:
        """Force (k,) along the axis on particles in their columns of a table, each of an area (k,) of the start, N."""
        widened = _width(table[X : X + 3, columns].T, self.across) / self.width
        outward = 1.0 if self.load.side else -1.0
        forces: np.ndarray = -outward * pressure * widened * areas
        return forces


def pressed_ends(problem: Problem, axes: int) -> list[PressedEnd]:
    """The ends that the tractions of a problem press on, in so many axes."""
    starts = np.cumsum([0, *(body.mass.size for body in problem.bodies)])
    ends = []
    for load in problem.tractions:
        body = problem.bodies[load.body]
        place = body.position[:, load.axis] * (1.0 if load.side else -1.0)
        layer = np.flatnonzero(place > place.max() - WITHIN * body.spacing[load.axis])
        across = tuple(axis for axis in range(axes) if axis != load.axis and np.ptp(body.position[layer, axis]) > 0.0)
        ends.append(
            PressedEnd(
                load,
                layer + starts[load.body],
                body.mass[layer] / (body.density * body.spacing[load.axis]),
                across,
                _width(body.position[layer], across),
            )
        )
    return ends


def _width(position: np.ndarray, across: tuple[int, ...]) -> float:
    return float(np.prod(position[:, across].std(axis=0)))
