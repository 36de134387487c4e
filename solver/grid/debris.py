"""Debris on its way out: it leaves the particles once nothing of the target can meet it any more.

Hot debris is the fastest of all matter and so sets the step of all, up to the edge of the grid, where it leaves. With
``Retirement`` a piece of it leaves as a whole as soon as

1. it has come off: at least one node lies between those that it reaches and those that the target does, so that neither
   feels a force of the other;
2. its way is clear: the straight path of each of its particles leads out of the grid past the target as it stands;
3. some time has passed: before, the target's surface is thrown out itself and might catch up with it;
4. its own pressure drives it apart no more: the mean of p / rho over its mass is no larger than ``expansion``. In a
   free body m <v^2> + 3 m <p / rho> is half of the second derivative of its moment of inertia (virial theorem, in which
   shear has no part): the mean is what its parts can still gain, v^2 / 2 of them. A piece is judged as a whole, because
   what is left of one that leaves by parts would expand into the gap.

The target is the piece with the most mass of one body. What is retired is booked and recorded like what leaves the
grid, which is where it flies (``state.Departed``). From there it flies straight: what the parts of a
piece would still do to one another, and pieces that would meet, are left out.
"""

import numpy as np

from solver.problem import Face, Problem
from solver.problem.geometry import MARGIN
from solver.state import Departed, Particles

NEIGHBOURS = np.ones((3, 3, 3), bool)  # no shape reaches farther than to those of the nearest node


def clear_debris(
    problem: Problem, particles: Particles, body: np.ndarray, *, expansion: float | None = None
) -> np.ndarray:
    """Indices of the particles that have come off the target and whose piece is on a clear way out of the grid.

    ``expansion`` (J/kg) is in place of that of the problem's rule.
    """
    from scipy import ndimage  # half a second, which runs that follow their debris need not wait for

    rule, geometry = problem.retirement, problem.geometry
    assert rule is not None
    living = np.flatnonzero(particles.alive)
    position, velocity = particles.position[living], particles.velocity[living]
    nearest = _nearest(problem, position)
    reached = np.zeros(tuple(geometry.nodes), bool)
    reached[nearest] = True
    piece, pieces = ndimage.label(ndimage.binary_dilation(reached, NEIGHBOURS), NEIGHBOURS)
    of = piece[nearest]
    of_body = np.where(body[living] == rule.body, particles.mass[living], 0.0)
    target = int(np.bincount(of, of_body).argmax())
    loose = np.flatnonzero(of != target)
    stays = np.zeros(pieces + 1, bool)
    stays[target] = True
    stays[of[loose[_meets(problem, position[loose], velocity[loose], piece == target)]]] = True
    mass = particles.mass[living]
    driven = np.bincount(of, mass * particles.pressure[living] / particles.density[living], pieces + 1)
    mean = driven / np.maximum(np.bincount(of, mass, pieces + 1), np.finfo(float).tiny)
    stays |= mean > (rule.expansion if expansion is None else expansion)
    return living[~stays[of]]


def flown(problem: Problem, departed: Departed, time: float) -> np.ndarray:
    """Where particles that have departed are at a time (s); (n, 3) m."""
    passed = (time - departed.time)[:, None]
    return _mirrored(problem, departed.position + passed * departed.velocity)


def flown_on_grid(problem: Problem, departed: Departed, time: float) -> np.ndarray:
    """Where particles that have departed are at a time (s) if that is on the grid, else NaN; (n, 3) m."""
    place = flown(problem, departed, time)
    return np.where(_is_inside(problem, place)[:, None], place, np.nan)


def _meets(problem: Problem, position: np.ndarray, velocity: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Which particles meet some nodes (of the grid, bool) on their straight path, or never leave the grid."""
    geometry = problem.geometry
    speed = np.abs(velocity).max(axis=1)
    meets = speed == 0.0
    flying = np.flatnonzero(~meets)
    # Two nodes at a time, because what the target reaches is three wide at least; a mirror doubles a path.
    stride = velocity * (2.0 * geometry.spacing / np.where(meets, 1.0, speed))[:, None]
    for step in range(int(geometry.cells.max()) + 1):
        place = _mirrored(problem, position[flying] + step * stride[flying])
        flying, place = (one[_is_inside(problem, place)] for one in (flying, place))
        hit = target[_nearest(problem, place)]
        meets[flying[hit]] = True
        flying = flying[~hit]
        if not flying.size:
            break
    meets[flying] = True
    return meets


def _nearest(problem: Problem, place: np.ndarray) -> tuple[np.ndarray, ...]:
    """Indices of the nearest node along each axis of places inside the grid."""
    geometry = problem.geometry
    node = np.rint((place - geometry.lower) / geometry.spacing).astype(np.int64)
    return tuple((node + MARGIN * (geometry.cells > 0)).T)


def _is_inside(problem: Problem, place: np.ndarray) -> np.ndarray:
    geometry = problem.geometry
    cell = (place - geometry.lower) / geometry.spacing
    inside: np.ndarray = ((cell >= 0.0) & (cell <= geometry.cells)).all(axis=1)
    return inside


def _mirrored(problem: Problem, place: np.ndarray) -> np.ndarray:
    """Places beyond a plane of symmetry, or beyond the axis, on this side of it."""
    geometry = problem.geometry
    upper = geometry.lower + geometry.cells * geometry.spacing
    for axis, (low, high) in enumerate(problem.faces):
        if low == Face.SYMMETRIC:
            place[:, axis] = geometry.lower[axis] + np.abs(place[:, axis] - geometry.lower[axis])
        if high == Face.SYMMETRIC:
            place[:, axis] = upper[axis] - np.abs(upper[axis] - place[:, axis])
    return place
