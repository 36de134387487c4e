"""Bodies that meet, each with a velocity field of its own: Bardenhagen, Brackbill and Sulsky (2000), Comput. Methods
Appl. Mech. Eng. 187, 529; Ma (2005), section 2.2.3.

A node that two bodies reach is where they may touch. They do when they would approach each other along the normal
after the step; then they get the impulse that gives both the normal velocity of their common centre of mass, and along
the surface as much of it as Coulomb's friction allows. The impulse is a force of the step like any other, equal and
opposite on the two fields. Energy of the relative motion that no stress has taken is accumulated as removed energy:
minus the impulse times the mean of the relative velocities before and after. The criteria differ in what they know:

``Criterion.STEP``    nothing of where bodies end, so that they meet about a cell before their surfaces do. Bodies must
    approach before the forces too: where these alone would make bodies approach that draw apart, the impulse would do
    work on them. Without this, slow elastic bars gained up to 44 % of their energy at the contact; with it they lose a
    sixth to a third of it. Its price is that bodies under pressure, whose mapped velocities draw apart at some nodes,
    creep into each other there, and what ends that approach later is removed: see docs/theory.md.
``Criterion.MAPPED``  the same with the velocities of the mapping, before the forces: Ma (2005), Eqs. 2-27 and 2-28.
    Bodies then approach after a step by what its forces gave, and slow elastic bars stick (2026-11). Each body's own
    normal, as printed, would not keep the momentum: both criteria have the shared one.
``Criterion.GAP``     the distance of the surfaces: a body ends, seen from a node, where the particles that have weight
    there end along the normal, each half of its present size beyond its place. The impulse leaves the approach that
    closes the gap within the step. That approach alone decides too early is known since Lemiale, Nairn and Hurmane
    (2010), CMES 70, 41 and Nairn (2013), CMES 92, 271, who add a displacement that is extrapolated to the node; Huang,
    Zhang, Ma and Huang (2011), Int. J. Numer. Meth. Eng. 85, 498, take the distance of the outermost particles, and
    Nairn, Hammerquist and Smith (2020), Comput. Methods Appl. Mech. Eng. 362, 112859, that of their edges, from the
    deformation of each. Here the size follows from the density alone: matter that was compressed along one axis
    counts as thicker than it is, by 0.04 cells between two bodies under 300 GPa, and matter that was drawn out along
    its surface as narrower, so that holes at 6 km/s come out too small on one cell through the plate.
    Bodies that touch touch until a gap opens, so that the approach before the forces is not asked for: what it was
    to prevent, the gap does. One limit remains: with linear functions, whose forces jump as particles change cells,
    contact would give up to 4 % more energy than it took. So the approach before is asked for whenever
    the normal impulses of two bodies have given back all that they took.
"""

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from solver.grid.nodes import Nodes, node_place, node_strides
from solver.grid.shapes import width
from solver.jit import device, kernel
from solver.problem import Contact, Criterion, Problem
from solver.problem.geometry import dimensions, triple, unpacked
from solver.state import DENSITY, MASS, X
from solver.steps.space import PACK, WIDEST, Pack, find_nodes, opened
from solver.vectors import element, number

# Round-off of distances, in sizes of a particle.
HAIR = 1e-9
# Cosine between a body's own normal and the shared one: a surface that the line hardly crosses says nothing of its end.
FACING = 0.1


class ContactPair(NamedTuple):
    """Two bodies that may touch."""

    impulse: np.ndarray  # (m, 3) that the first got from the second at each node, N s
    taken: np.ndarray  # (1,) energy that normal impulses removed so far, where the gap is known, J
    # Where the gap is known; else of no node.
    normal: np.ndarray  # (m, 3) from the first to the second; zero at nodes that both do not reach
    # (m, 2) how far from the node towards the other each body reaches along it, m.
    reach: np.ndarray
    support: np.ndarray  # (m, 2) how far each reaches along the normal of its own surface, m


class Side(NamedTuple):
    """What contact reads and writes of the nodes of a body, as ``nodes.Nodes`` has it.

    All nodes together took kernels twice as long to compile, and again where they have no columns for damping.
    """

    mass: np.ndarray
    momentum: np.ndarray
    force: np.ndarray
    before: np.ndarray
    surface: np.ndarray


class BodySize(NamedTuple):
    """The size of a body's particles at the start."""

    spacing: tuple[float, float, float]  # m
    density: float  # kg/m3


class NodalContact:
    """Contact between the velocity fields of a problem, a body each, pair after pair."""

    def __init__(self, problem: Problem, contact: Contact, nodes: Sequence[Nodes]):
        self.problem, self.contact = problem, contact
        count = len(nodes[0].mass)
        known = count if contact.criterion == Criterion.GAP else 0
        self.sizes = [BodySize(triple([*map(float, body.spacing)]), float(body.density)) for body in problem.bodies]
        self.sides = [Side(*(getattr(own, name) for name in Side._fields)) for own in nodes]
        self.pairs = [
            (
                first,
                second,
                ContactPair(
                    np.zeros((count, 3)), np.zeros(1), np.zeros((known, 3)), np.zeros((known, 2)), np.zeros((known, 2))
                ),
            )
            for first, second in itertools.combinations(range(len(nodes)), 2)
        ]

    def add_forces(self, table: np.ndarray, shares: np.ndarray, pack: Pack, dt: float) -> None:
        """Contact forces between fields whose mass, momentum, force and surface are complete.

        ``shares`` (s, bodies, 2) is where each body's particles begin and end in each share of the table.
        """
        geometry, shape = self.problem.geometry, self.problem.shape
        ahead = 0.0 if self.contact.criterion == Criterion.MAPPED else dt
        for first, second, pair in self.pairs:
            one, other = self.sides[first], self.sides[second]
            if pair.reach.size:
                sizes = self.sizes[first], self.sizes[second]
                ranges = np.ascontiguousarray(shares[:, [first, second]].swapaxes(0, 1))
                measure_gaps(geometry, shape, pack, table, ranges, sizes, one, other, pair)
            add_contact_forces(one, other, pair, self.contact.friction, ahead, dt)

    def energy_removed(self) -> float:
        """Energy that contact removed in the step, J."""
        return math.fsum(
            energy_removed(self.sides[first], self.sides[second], pair) for first, second, pair in self.pairs
        )

    def taken(self) -> np.ndarray:
        """What the pairs remember from step to step (pairs,), J."""
        return np.array([pair.taken[0] for _, _, pair in self.pairs])

    def take_over(self, taken: np.ndarray) -> None:
        """Go on from what ``taken`` gave."""
        for (_, _, pair), energy in zip(self.pairs, taken, strict=True):
            pair.taken[0] = energy


@kernel
def measure_gaps(geometry, shape, pack, table, ranges, sizes, first, second, pair):
    """Where along the shared normal of each node two bodies end, by the particles that have weight there.

    ``ranges`` (2, s, 2) are the places of the particles of either body, ``sizes`` (2,) how large they are. Largest and
    smallest do not depend on the order of particles.
    """
    geometry, pack = unpacked(geometry), opened(pack)
    low, high = np.empty(3), np.empty(3)
    for axis in range(3):
        low[axis], high[axis] = np.inf, -np.inf
    for i in range(first.mass.size):
        for c in range(3):
            pair.normal[i, c] = 0.0
        if first.mass[i] <= 0.0 or second.mass[i] <= 0.0:
            continue
        size = 0.0
        for c in range(3):
            pair.normal[i, c] = first.surface[i, c] - second.surface[i, c]
            size += pair.normal[i, c] ** 2
        if size <= 0.0:
            continue
        for c in range(3):
            pair.normal[i, c] /= math.sqrt(size)
        for body in range(2):
            pair.reach[i, body] = pair.support[i, body] = -np.inf
        for axis in range(dimensions(geometry)):
            place = node_place(geometry, i, axis)
            low[axis], high[axis] = min(low[axis], place), max(high[axis], place)
    for body in range(2):
        for share in range(ranges.shape[1]):
            begin, end = ranges[body, share, 0], ranges[body, share, 1]
            surface = first.surface if body == 0 else second.surface
            for start in range(begin, end, PACK):
                stop = min(start + PACK, end)
                if not _any_near(geometry, table, start, stop, low, high):
                    continue
                find_nodes(geometry, shape, table, start, stop, pack)
                for k in range(stop - start):
                    p = start + k
                    if table[MASS, p] > 0.0:
                        _extend(geometry, shape, table, p, k, pack, pair, body, sizes[body], surface)


@device
def _any_near(geometry, table, start, stop, low, high):
    """Whether a particle of start..stop may have weight at a node of a box, ``low`` to ``high`` (3,) in cells."""
    for p in range(start, stop):
        near = True
        for axis in range(dimensions(geometry)):
            place = (table[X + axis, p] - geometry.lower[axis]) / geometry.spacing
            near = near and low[axis] - WIDEST < place < high[axis] + WIDEST
        if near:
            return True
    return False


@device
def _extend(geometry, shape, table, p, k, pack, pair, body, sizes, surface):
    """Move the end of a body at the nodes of particle ``p``, the ``k``-th of its pack, to where this one ends.

    A particle is an ellipsoid that grows alike along all axes: turned matter is as thick as before it turned. Matter
    that stands sideways of a node is not what meets there. Two bounds of the end say so: a particle covers the line
    along the normal through a node if it is no farther away from it than neighbours in a lattice are, and beside that
    its end falls off by 45 degrees; and no matter lies beyond the plane of the body's own ``surface`` that supports it.
    """
    grown = (sizes.density / table[DENSITY, p]) ** (1.0 / 3.0)
    s0, s1, s2 = sizes.spacing
    solid = dimensions(geometry) == 3
    # Matter that is compressed along one axis is as wide as before along the others.
    covered = (0.5 + HAIR) * max(1.0, grown) * max(s0, s1, s2) * (math.sqrt(2.0) if solid else 1.0)
    first = np.int64(element(pack.first, k))
    along_first, along_second, along_third = node_strides(geometry)
    for a in range(width(shape)):
        for b in range(width(shape)):
            for c in range(width(shape) if solid else 1):
                weight = number(pack.weight, a, k) * number(pack.weight, WIDEST + b, k)
                if solid:
                    weight *= number(pack.weight, 2 * WIDEST + c, k)
                row = first + a * along_first + b * along_second + c * along_third
                n0, n1, n2 = pair.normal[row, 0], pair.normal[row, 1], pair.normal[row, 2]
                if weight <= 0.0 or n0 * n0 + n1 * n1 + n2 * n2 == 0.0:
                    continue
                along = apart = outwards = area = 0.0
                for axis in range(dimensions(geometry) - 1, -1, -1):
                    node = geometry.lower[axis] + geometry.spacing * node_place(geometry, row, axis)
                    offset = table[X + axis, p] - node
                    along += offset * pair.normal[row, axis]
                    apart += offset * offset
                    outwards += offset * surface[row, axis]
                    area += surface[row, axis] ** 2
                beside = math.sqrt(max(0.0, apart - along * along))
                half = math.sqrt((n0 * s0) ** 2 + (n1 * s1) ** 2 + (n2 * s2) ** 2)
                end = 0.5 * grown * half - max(0.0, beside - covered)
                end += along if body == 0 else -along
                pair.reach[row, body] = max(pair.reach[row, body], end)
                if area > 0.0:
                    a0, a1, a2 = surface[row, 0], surface[row, 1], surface[row, 2]
                    half = math.sqrt((a0 * s0) ** 2 + (a1 * s1) ** 2 + (a2 * s2) ** 2)
                    end = (outwards + 0.5 * grown * half) / math.sqrt(area)
                    pair.support[row, body] = max(pair.support[row, body], end)


@device
def _gap(pair, first, second, i):
    """Distance of two bodies along the normal of a node, m; negative where they overlap."""
    gap = 0.0
    for body in range(2):
        surface = first.surface if body == 0 else second.surface
        area = facing = 0.0
        for c in range(3):
            area += surface[i, c] ** 2
            facing += surface[i, c] * pair.normal[i, c]
        if body == 1:
            facing = -facing
        end = pair.reach[i, body]
        if facing > FACING * math.sqrt(area):
            end = min(end, pair.support[i, body] * math.sqrt(area) / facing)
        gap -= end
    return gap


@kernel
def add_contact_forces(first, second, pair, friction, ahead, dt):
    """Contact forces between two fields whose mass, momentum, force and surface are complete.

    The impulse ends the approach that the bodies would have ``ahead`` of now: after the step (dt), or at once (0).

    The normal is that of the difference of the two surfaces, so that both fields see the same one. That of the larger
    surface alone (Lemiale, Nairn and Hurmane 2010, CMES 70, 41) is better where a corner slides on a flat, and
    much worse where two corners pass each other (2026-11).
    """
    knows_gap = pair.reach.size > 0
    gives_back = knows_gap and pair.taken[0] > 0.0
    normal, relative = np.empty(3), np.empty(3)
    for i in range(first.mass.size):
        for c in range(3):
            pair.impulse[i, c] = 0.0
        if first.mass[i] <= 0.0 or second.mass[i] <= 0.0:
            continue
        size = approach = before = 0.0
        for c in range(3):
            normal[c] = first.surface[i, c] - second.surface[i, c]
            size += normal[c] * normal[c]
            relative[c] = _velocity(first, i, c, ahead) - _velocity(second, i, c, ahead)
            approach += relative[c] * normal[c]
            before += (_velocity(first, i, c, 0.0) - _velocity(second, i, c, 0.0)) * normal[c]
        if approach <= 0.0 or (before <= 0.0 and not gives_back):
            continue
        size = math.sqrt(size)
        approach /= size
        sliding = 0.0
        for c in range(3):
            normal[c] /= size
            relative[c] -= approach * normal[c]
            sliding += relative[c] * relative[c]
        if knows_gap:
            approach -= max(0.0, _gap(pair, first, second, i)) / dt
            if approach <= 0.0:
                continue
        # Coulomb: what stops the sliding, but at most friction times the normal impulse.
        grip = min(1.0, friction * approach / math.sqrt(sliding)) if sliding > 0.0 else 0.0
        reduced = first.mass[i] * second.mass[i] / (first.mass[i] + second.mass[i])
        for c in range(3):
            given = -reduced * (approach * normal[c] + grip * relative[c])
            pair.impulse[i, c] = given
            first.force[i, c] += given / dt
            second.force[i, c] -= given / dt


@device
def _velocity(nodes, i, c, ahead):
    """Velocity after a time without contact."""
    return (nodes.momentum[i, c] + nodes.force[i, c] * ahead) / nodes.mass[i]


@kernel
def energy_removed(first, second, pair):
    """Energy that contact removed: minus the work of its impulses in the mean of old and new velocity; J.

    The part of the normal impulses is added to ``pair.taken`` where the gap is known.
    """
    energy = 0.0
    normal = pair.normal
    for i in range(first.mass.size):
        if first.mass[i] <= 0.0 or second.mass[i] <= 0.0:
            continue
        push = closing = 0.0
        for c in range(3):
            before = first.before[i, c] - second.before[i, c]
            after = first.momentum[i, c] / first.mass[i] - second.momentum[i, c] / second.mass[i]
            energy -= 0.5 * pair.impulse[i, c] * (before + after)
            if normal.size:
                push -= pair.impulse[i, c] * normal[i, c]
                closing += 0.5 * (before + after) * normal[i, c]
        pair.taken[0] += push * closing
    return energy
