"""One step by smoothed particles, in its stages.

Particles hold x, v, sigma at time n; all sums take the neighbours and weights of x at n.

forces   leapfrog: v(n+1/2) = v(n-1/2) + a(n) k with k half of the step before and half of this one, and
         x(n+1) = x(n) + v(n+1/2) dt; a problem begins with half a step of force
strain   the gradient of v(n+1/2), from which density, stress and energy at n+1 follow, point by point as on the grid

The forces of stress n change the kinetic energy by f . (v(n-1/2) + v(n+1/2)) / 2 k, and the internal energy takes minus
that with the same weights: half of k in the first velocity, half of k less half of dt in the second one, and the point
update the rest. Their sum is kept to round-off, whatever stress and steps are.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from solver.errors import ProblemError
from solver.jit import Bound
from solver.methods.sph.contact import reached, repel
from solver.methods.sph.loads import pressed_ends
from solver.methods.sph.neighbours import Cells, find_neighbours, sort_into_cells
from solver.methods.sph.rates import (
    FASTEST,
    IMPULSE,
    STILL,
    TOUCHED,
    WEIGHT,
    WORK,
    Lists,
    accelerate,
    find_forces_of_others,
    find_gradients,
    lay_out,
    measure,
    set_stress,
    tensile_part,
)
from solver.methods.sph.smoothing import SUPPORT
from solver.methods.sph.tables import MOVED, images_of, new_memory, set_places, set_stresses, set_velocities, tables_of
from solver.problem import Face, Problem, Smoothing, mean_pressure
from solver.problem.geometry import Cartesian3D
from solver.state import MASS, VX, Particles, lines
from solver.steps.crossing import cross_faces
from solver.steps.method import Method, Partition, StepBalance, refuse
from solver.steps.points import PointUpdate, StateLimits
from solver.steps.space import AXES, Gridless
from solver.steps.threads import ThreadPool

STRETCHED = 2.0  # largest smoothing length of thin matter, over that at the initial density
LISTED = 100  # neighbours of a particle in the first lists; lists that are too short double
STANDSTILL = 1e-300  # 1/s: cold gas that nothing touches has no signal, and its steps grow
# Distance in cells within which a particle stands on a plane of symmetry and has a part of its mass.
ON_PLANE = 1e-6
SPARE = 1.2  # of the rows of the tables


@dataclass
class LoadedLayer:
    """Particles that a traction presses on in a step."""

    axis: int
    columns: np.ndarray  # (k,) of the table
    forces: np.ndarray  # (k,) along the axis, N
    before: np.ndarray  # (k,) velocities along it before and after the step, m/s
    after: np.ndarray


class ParticleStepper(Method):
    """The stages of a step over one problem's arrays; ``shares`` of the particles may be done at once."""

    def __init__(self, problem: Problem, limits: StateLimits, pool: ThreadPool, shares: int):
        if problem.smoothing is None:
            raise ProblemError("smoothed particles need the numerics of their smoothing")
        _check(problem, problem.smoothing)
        self.problem = problem
        self.smoothing = problem.smoothing
        self.pool = pool
        self.axes = _axes(problem)
        self.pressed = pressed_ends(problem, self.axes)
        self.loaded: list[LoadedLayer] = []
        self.before = np.zeros(1)  # the step that ended at n, s
        geometry, lengths = problem.geometry, np.zeros((1, problem.particle_count))
        self.space = Gridless(geometry.lower, geometry.spacing, geometry.cells, self.axes, lengths)
        self.points = PointUpdate(problem, limits, shares)
        self.sums = np.zeros((shares, 8))
        self.faces = np.array(problem.faces, dtype=np.int64).reshape(3, 2)
        self.gravity = np.array(problem.gravity)
        self.lists = [np.zeros(0, np.int32)] * shares
        self.memory = new_memory(0, self.smoothing.tensile > 0.0)
        self.measures = np.zeros((2, 0))
        bodies = range(len(problem.bodies))
        # The number of the solid of each body; without contact all are one, and meet in the sums.
        self.solids = [body if self.smoothing.stiffness > 0.0 else 0 for body in bodies]
        # Bodies whose particles move, those that neighbours see and another method moves, and both.
        self.active = [number for number in bodies if problem.bodies[number].mesh is None]
        self.passive = [number for number in bodies if number not in self.active]
        self.seen = list(bodies)
        self.measure = [Bound(measure) for _ in bodies]
        self.lay_out, self.set_stress = Bound(lay_out), Bound(set_stress)
        self.find_neighbours, self.repel = Bound(find_neighbours), Bound(repel)
        self.accelerate, self.find_gradients = Bound(accelerate), Bound(find_gradients)
        self.find_forces_of_others = Bound(find_forces_of_others)

    def carried(self) -> dict[str, np.ndarray]:
        """The step before."""
        return {"before": self.before}

    def take_over(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from what ``carried`` gave."""
        self.before = arrays["before"]

    def advance(self, partition: Partition, time: float, dt: float) -> StepBalance:
        """Take the particles from n, at a time, to n+1."""
        kick = 0.5 * (float(self.before[0]) + dt)
        self.before = np.array([dt])
        self.push(partition, time, kick, dt)
        self.strain(partition, time, kick, dt)
        return self.balance(partition, kick)

    def push(self, partition: Partition, time: float, kick: float, dt: float) -> None:
        """Velocities after a ``kick`` (s) and positions after the step."""
        smoothing, axes = self.smoothing, self.axes
        table, count = partition.table, partition.particles.mass.size
        self._room(count)
        self._measure(partition)
        images = images_of(self.problem, axes, partition.particles.position, self.measures[0])
        whole = count + images.source.size
        if whole >= self.memory.place.shape[0]:
            self.memory = new_memory(int(SPARE * whole) + 1, smoothing.tensile > 0.0)
        self.tables, self.images = tables_of(self.memory, whole), images
        tables = self.tables
        self._over_shares(
            partition,
            lambda share, ranges: self.lay_out(table, self.measures, ranges, tables.place, tables.other),
            self.seen,
        )
        set_places(tables, images, count)
        solid = self._solid_of(partition, images.source)
        cells = sort_into_cells(tables.place, solid, whole)
        self._over_shares(partition, lambda share, ranges: self._find(share, ranges, cells, solid), self.seen)
        self._over_shares(
            partition,
            lambda share, ranges: self.set_stress(table, self.correction, ranges, tables.stress, tables.other),
            self.seen,
        )
        if smoothing.tensile > 0.0:
            tables.tensile[:count, :6] = tensile_part(smoothing, table[:, :count])
        set_stresses(tables, images, count)
        self._push_apart(cells, solid, count)
        self._press(partition, time, dt)
        sums = smoothing, axes, tables, table
        pushes = self.pushed, self.gravity, kick, dt
        self._over_shares(
            partition,
            lambda share, ranges: self.accelerate(*sums, ranges, self._lists(share), *pushes, self.sums[share]),
            self.active,
        )
        for loaded in self.loaded:
            loaded.after = table[VX + loaded.axis, loaded.columns].copy()

    def forces_of_others(self, partition: Partition, particles: np.ndarray) -> np.ndarray:
        """Forces (k, 6) on some particles by what another method moves, and by images of it alone, N.

        They are those of the sums of the last ``push``.
        """
        count = partition.particles.mass.size
        marks = lines(self.tables.place.shape[0])
        for begin, end in partition.shares[:, self.passive].reshape(-1, 2):
            marks[begin:end, 0] = 1.0
        images = marks[count : count + self.images.source.size]
        images[:, :2] = marks[self.images.source, :1]
        forces = np.zeros((particles.size, 6))
        for share, ranges in enumerate(partition.shares[:, self.active]):
            inside = np.zeros(particles.size, bool)
            for begin, end in ranges:
                inside |= (particles >= begin) & (particles < end)
            mine = np.flatnonzero(inside)
            found = np.zeros((mine.size, 6))
            sums = self.smoothing, self.axes, self.tables, partition.table
            self.find_forces_of_others(*sums, particles[mine], self._lists(share), marks, found)
            forces[mine] = found
        return forces

    def strain(self, partition: Partition, time: float, kick: float, dt: float) -> None:
        """Density, stress and energy at n+1."""
        table = partition.table
        for begin, end in partition.shares[:, self.passive].reshape(-1, 2):
            self.tables.other[begin:end, MOVED : MOVED + AXES] = table[VX : VX + AXES, begin:end].T
        set_velocities(self.tables, self.images, partition.particles.mass.size)
        sums = self.smoothing, self.axes, self.tables, table
        found = self.correction, self.gradients, kick, dt
        self._over_shares(
            partition, lambda share, ranges: self.find_gradients(*sums, ranges, self._lists(share), *found), self.active
        )

        def update(share: int) -> None:
            for body in self.active:
                span = partition.shares[share, body].tolist()
                self.points.update(self.space, STILL, share, body, table, span, self.gradients, time + dt, dt)

        self.pool.run(update, range(len(self.sums)))

    def balance(self, partition: Partition, kick: float) -> StepBalance:
        """What the step exchanged with faces and gravity."""
        impulse = np.zeros(3)
        # The signal that takes as long through a cell as the one that decides through its smoothing length.
        signal = self.problem.geometry.spacing * max(float(self.sums[:, FASTEST].max()), STANDSTILL)
        tally = self.points.tally()._replace(signal=signal, convected=signal)
        impulse += self.sums[:, IMPULSE : IMPULSE + 3].sum(axis=0)
        impulse += self.sums[:, WEIGHT].sum() * self.gravity * kick
        gone, reflected = 0, 0
        if tally.outside:
            # Bodies that another method moves come first.
            first = int(partition.shares[:, self.active, 0].min())
            moved = Particles(*(array[first:] for array in partition.particles))
            gone, reflected = cross_faces(self.problem.geometry, self.faces, self.problem.clamp, moved, impulse)
        pressed = 0.0
        for loaded in self.loaded:
            impulse[loaded.axis] += loaded.forces.sum() * kick
            pressed += 0.5 * float(loaded.forces @ (loaded.before + loaded.after)) * kick
        work = float(self.sums[:, WORK].sum()) + pressed
        # What contact gives to the motion of particles comes out of what it took before.
        taken = pressed - float(self.sums[:, TOUCHED].sum())
        return StepBalance(impulse, 0.0, taken, work, gone, reflected, tally)

    def _room(self, count: int) -> None:
        """Scratch for so many particles."""
        if self.measures.shape[1] != count:
            self.measures = np.zeros((2, count))
            self.first, self.stop = np.zeros((2, count), np.int64)
            self.correction = lines(count)
            self.pushed = lines(count)
            self.gradients = lines(AXES * count)

    def _solid_of(self, partition: Partition, source: np.ndarray) -> np.ndarray:
        """Number of the solid of each particle and of the images of some."""
        solid = np.zeros(partition.particles.mass.size, np.int32)
        for body, number in enumerate(self.solids):
            for begin, end in partition.shares[:, body]:
                solid[begin:end] = number
        return np.concatenate([solid, solid[source]])

    def _push_apart(self, cells: Cells, solid: np.ndarray, count: int) -> None:
        """Accelerations by contact."""
        self.pushed[:] = 0.0
        if self.smoothing.stiffness == 0.0:
            return
        place, other, pushed = self.tables.place, self.tables.other, self.pushed
        near = reached(place, solid, count)
        pieces = [near[begin:end] for begin, end in self.pool.ranges(near.size)] if near.size else []
        self.pool.run(
            lambda particles: self.repel(self.smoothing, self.axes, cells, place, other, solid, particles, pushed),
            pieces,
        )

    def _press(self, partition: Partition, time: float, dt: float) -> None:
        """Accelerations by pressures on ends, beside those by contact."""
        self.loaded = []
        if not self.pressed:
            return
        table, particles = partition.table, partition.particles
        column = np.full(self.problem.particle_count, -1)
        living = np.flatnonzero(particles.alive)
        column[particles.number[living]] = living
        for end in self.pressed:
            pressure = mean_pressure(end.load, time, time + dt)
            if pressure:
                axis, columns = end.load.axis, column[end.numbers]
                here = columns >= 0  # what has left the grid carries nothing
                columns = columns[here]
                forces = end.forces(table, columns, end.areas[here], pressure)
                self.pushed[columns, axis] += forces / table[MASS, columns]
                before = table[VX + axis, columns].copy()
                self.loaded.append(LoadedLayer(axis, columns, forces, before, before))

    def _measure(self, partition: Partition) -> None:
        """Smoothing lengths and sound speeds."""
        ratio, axes = self.smoothing.ratio, self.axes

        def measure(share: int) -> None:
            for number, body in enumerate(self.problem.bodies):
                begin, end = partition.shares[share, number].tolist()
                thinnest = body.density / STRETCHED**axes
                self.measure[number](body.matter, ratio, axes, thinnest, partition.table, begin, end, self.measures)

        self.pool.run(measure, range(len(self.sums)))
        # A particle on a plane of symmetry has the length of the mass that it has with its images.
        geometry, length = self.problem.geometry, self.measures[0]
        for axis in range(axes):
            for side, face in enumerate(self.problem.faces[axis]):
                if face == Face.SYMMETRIC:
                    wall = geometry.lower[axis] + side * geometry.cells[axis] * geometry.spacing
                    away = np.abs(partition.particles.position[:, axis] - wall)
                    length[away < ON_PLANE * geometry.spacing] *= 2.0 ** (1.0 / axes)
        if self.passive:
            self._hide(partition)

    def _hide(self, partition: Partition) -> None:
        """Take the smoothing length of what another method moves where it has no part in the sums of particles.

        A part have the neighbours of particles, and theirs, which correct their gradients: by the box of the particles.
        """
        position, length = partition.particles.position[:, : self.axes], self.measures[0]
        own, others = (
            np.concatenate([np.arange(*edges) for edges in partition.shares[:, bodies].reshape(-1, 2)])
            for bodies in (self.active, self.passive)
        )
        own = own[length[own] > 0.0]
        if not own.size:
            return
        low, high = position[own].min(axis=0), position[own].max(axis=0)
        away = np.maximum(low - position[others], position[others] - high).max(axis=1)
        near = away - length[others] <= length[own].max()
        farthest = (away + length[others])[near].max(initial=0.0)
        length[others[away - length[others] > farthest]] = 0.0

    def _find(self, share: int, ranges: np.ndarray, cells: Cells, solid: np.ndarray) -> None:
        """The neighbours of the particles of a share, in lists that are long enough."""
        if not self.lists[share].size:
            size = int((ranges[:, 1] - ranges[:, 0]).sum())
            self.lists[share] = np.zeros(LISTED * (size + 1), np.int32)
        seen = self.smoothing, self.axes, cells, self.tables.place, solid, self.tables.other, ranges
        found = self.first, self.stop, self.correction
        while self.find_neighbours(*seen, self.lists[share], *found) < 0:
            self.lists[share] = np.zeros(2 * self.lists[share].size, np.int32)

    def _lists(self, share: int) -> Lists:
        return Lists(self.lists[share], self.first, self.stop)

    def _over_shares(
        self, partition: Partition, call: Callable[[int, np.ndarray], None], bodies: Sequence[int]
    ) -> None:
        """A call for each share, with the ranges (bodies, 2) of the particles of some bodies in it."""
        ranges = np.ascontiguousarray(partition.shares[:, bodies])
        self.pool.run(lambda share: call(share, ranges[share]), range(len(self.sums)))


def _axes(problem: Problem) -> int:
    """Axes along which the problem has extent."""
    return int((np.asarray(problem.geometry.cells) > 0).sum())


def _narrow(problem: Problem, smoothing: Smoothing) -> bool:
    """Whether images of particles at one closed face would lie beyond the other one."""
    reach = SUPPORT * smoothing.ratio * max(max(body.spacing[: _axes(problem)]) for body in problem.bodies)
    return any(
        Face.FREE not in problem.faces[axis] and problem.geometry.cells[axis] * problem.geometry.spacing < reach
        for axis in range(_axes(problem))
    )


def _check(problem: Problem, smoothing: Smoothing) -> None:
    """Refuse what the method cannot compute, by name."""
    cells = np.asarray(problem.geometry.cells) > 0
    kinds = {face for axis in range(_axes(problem)) for face in problem.faces[axis]}
    more = {
        "an axisymmetric geometry (take a box)": not isinstance(problem.geometry, Cartesian3D),
        "an axis with cells behind one without (reorder them)": bool(np.diff(cells * 1).max() > 0),
        "walls that let go (take symmetric faces)": Face.WALL in kinds,
        "a box too narrow for images behind both of its faces (widen it)": _narrow(problem, smoothing),
    }
    refuse(problem, "smoothed particles", more)
