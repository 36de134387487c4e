"""From one grid to the next: what has departed flies straight, and joins another grid at its face.

Matter that a stage leaves behind, debris that flies past the next grid, what flies backwards and what would have come
to the stage after its end stay in the books, so that those of the last stage hold everything from the first one on. A
flight that crosses a plane of symmetry, or the axis, goes on as that of its mirror image; what the plane gives to it is
booked as an impulse.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from solver import state
from solver.audit import BodyBalance, Books, Ledger, body_balances, left_behind
from solver.grid.debris import clear_debris
from solver.problem import Face, Problem
from solver.problem.geometry import Geometry, impact_axis
from solver.state import NONE_DEPARTED, Arrivals, Departed, Snapshot, columns, joined, records, views
from solver.steps.crossing import SHEAR

NOTHING = BodyBalance(*[0.0] * 6)  # that a body has left behind
ENTRY = 0.5  # cells inside the face of the next grid: no round-off puts what joins outside


class Flight(NamedTuple):
    """What flies from one grid to the next, and the books of everything else."""

    arrivals: Arrivals  # their times on the clock of the next stage
    number: np.ndarray  # (k,) of each arrival, its number in the stage that it left
    books: Books
    missed: float  # mass that flies past the next grid, or comes too late to its own, kg (per radian in axisymmetry)
    ahead: float  # time by which the clock of the next stage is later than that of this flight, s
    # Angular momentum, along the axis across line of flight and first axis, of what no plane has turned: by how much
    # it differs at the two ends, over the sum of its absolute values.
    angular_momentum_error: float


def fly(
    problem: Problem, snapshot: Snapshot, books: Books, *, geometry: Geometry, shift: np.ndarray, bodies: int
) -> Flight:
    """The flight from the end of a stage to the grid ``geometry`` of the next one.

    ``shift`` (3,) is the place of the next origin on the present grid, m. The next clock goes on from the end of this
    stage, and the first particle arrives then. Of the ``bodies`` of the next stage the first are
    those of this one. Debris that is on a clear way out departs at the end, whatever its pressure.
    """
    departed, expanding, stays = _ended(problem, snapshot)
    which, time, arriving = _entering(problem, departed, geometry, shift)
    past = np.setdiff1d(np.arange(departed.number.size), which)
    missed = Departed(*(array[past] for array in departed))
    axis = impact_axis(problem.geometry)
    before, base = problem.books, problem.books.ledger if problem.books else Ledger()
    late, ledger = _late(problem, snapshot), base
    for left_out in (missed, stays, late):
        ledger = ledger.with_particles(left_out, slice(None))
    turned = ((arriving[state.VX : state.VZ + 1] - departed.velocity[which].T) * departed.mass[which]).sum(axis=1)
    nothing = views(arriving[:, :0]), departed.body[:0]
    behind = [(matter, matter.body) for matter in (missed, stays, late)]
    left = body_balances(problem.geometry, nothing, *behind, count=bodies)
    ahead = snapshot.time - float(time[0]) if time.size else 0.0
    return Flight(
        arrivals=Arrivals(time + ahead, departed.body[which], arriving),
        number=departed.number[which],
        books=replace(
            books,
            ledger=replace(ledger, expanding=books.ledger.expanding + expanding),
            impulse=books.impulse + turned,
            left=left_behind(left, (*before.left, *[NOTHING] * (bodies - len(before.left)))) if before else left,
        ),
        missed=float(missed.mass[missed.velocity[:, axis] > 0.0].sum() + late.mass.sum()),
        ahead=ahead,
        angular_momentum_error=_angular_momentum_error(departed, which, arriving, shift, axis),
    )


def _angular_momentum_error(
    departed: Departed, which: np.ndarray, arriving: np.ndarray, shift: np.ndarray, axis: int
) -> float:
    """How well the records (k,) of ``which`` keep their angular momentum as the columns that arrive, relative."""
    straight = departed.velocity[which, 0] == arriving[state.VX]
    ends = (
        (departed.position[which].T, departed.velocity[which].T),
        (arriving[state.X : state.Z + 1] + shift[:, None], arriving[state.VX : state.VZ + 1]),
    )
    first, last = (
        (departed.mass[which] * (place[axis] * velocity[0] - place[0] * velocity[axis]))[straight]
        for place, velocity in ends
    )
    scale = float(np.abs(first).sum())
    return abs(float(last.sum() - first.sum())) / scale if scale else 0.0


def _ended(problem: Problem, snapshot: Snapshot) -> tuple[Departed, float, Departed]:
    """All that has departed at the end of a stage, the mass (kg) of it that still expanded, and all that stays."""
    particles, body = snapshot.particles, snapshot.body

    def recorded(index: np.ndarray) -> Departed:
        return records(snapshot.time, particles, body, index, snapshot.remembered)

    gone = clear_debris(problem, particles, body, expansion=math.inf)
    expanding = float(particles.mass[np.setdiff1d(gone, clear_debris(problem, particles, body))].sum())
    stays = np.setdiff1d(np.flatnonzero(particles.alive), gone)
    return joined([snapshot.departed, recorded(gone)]), expanding, recorded(stays)


def _late(problem: Problem, snapshot: Snapshot) -> Departed:
    """Arrivals of a stage that have not joined it at its end, each at its own time of arrival."""
    arrivals = problem.arrivals
    if arrivals is None:
        return NONE_DEPARTED
    count = arrivals.time.size
    first = problem.particle_count - count  # they join in order, with the last numbers of all
    numbers = np.concatenate([snapshot.particles.number, snapshot.departed.number])
    which = np.arange(max(0, int(numbers.max(initial=-1)) + 1 - first), count)
    late = views(arrivals.table, first + np.arange(count))
    return records(arrivals.time[which], late, arrivals.body, which, arrivals.table[state.HARDENED :])


def _entering(
    problem: Problem, departed: Departed, geometry: Geometry, shift: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which records (k,) come to the face of the next grid, when (k,), and their columns there, in that order."""
    axis, table = impact_axis(problem.geometry), columns(departed)
    place = geometry.lower[axis] + ENTRY * geometry.spacing
    which = np.flatnonzero(departed.velocity[:, axis] > 0.0)
    passed = (place + shift[axis] - departed.position[which, axis]) / departed.velocity[which, axis]
    arriving = flown_columns(problem, table[:, which], passed)
    arriving[state.X : state.Z + 1] -= shift[:, None]
    arriving[state.X + axis] = place
    time = departed.time[which] + passed
    order = np.argsort(time, kind="stable")
    order = order[is_on_grid(geometry, arriving[state.X : state.Z + 1].T)[order]]
    return which[order], time[order], np.ascontiguousarray(arriving[:, order])


def flown_columns(problem: Problem, table: np.ndarray, passed: np.ndarray) -> np.ndarray:
    """Columns of a table (rows, k) of particles that have flown straight for some time (k,), s.

    Behind a plane of symmetry, or the axis, they are their mirror images.
    """
    table, geometry = table.copy(), problem.geometry
    for axis in range(3):
        table[state.X + axis] += passed * table[state.VX + axis]
    for axis, faces in enumerate(problem.faces):
        for side, face in enumerate(faces):
            if face != Face.SYMMETRIC:
                continue
            wall = geometry.lower[axis] + side * geometry.cells[axis] * geometry.spacing
            beyond = table[state.X + axis] > wall if side else table[state.X + axis] < wall
            table[state.X + axis, beyond] = 2.0 * wall - table[state.X + axis, beyond]
            for row in (state.VX + axis, *(state.S11 + component for component in SHEAR[axis])):
                table[row, beyond] *= -1.0
    return table


def is_on_grid(geometry: Geometry, position: np.ndarray) -> np.ndarray:
    """Which places (n, 3) lie inside a grid."""
    cell = (position - geometry.lower) / geometry.spacing
    inside: np.ndarray = ((cell >= 0.0) & (cell < geometry.cells) | (geometry.cells == 0)).all(axis=1)
    return inside
