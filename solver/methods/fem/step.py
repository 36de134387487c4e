"""One step by finite elements, in its stages.

Nodes hold x and v, elements sigma at time n; operators take the positions of n.

forces   of the elements on their nodes; v(n+1/2) = v(n-1/2) + f k / m with k half of the step before and half of this
         one, x(n+1) = x(n) + v(n+1/2) dt: central differences
strain   the gradient of v(n+1/2), from which density, stress and energy at n+1 follow, element by element as on the
         grid particle by particle

The forces change the kinetic energy by f . (v(n-1/2) + v(n+1/2)) / 2 k, and the elements take minus that, half with the
forces and half with the strain, as in ``solver/grid/step.py``: their sum is kept to round-off, whatever the stress is.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from solver.jit import Bound
from solver.matter.eos import reference_density, reference_sound_speed
from solver.methods.fem.elements import NODES
from solver.methods.fem.mesh import end_faces, face_areas, node_parts, volumes_of
from solver.methods.fem.rates import (
    HELD,
    IMPULSE,
    WORK,
    find_operators,
    meshed,
    move_nodes,
    push_nodes,
    show_nodes,
    strain_elements,
)
from solver.problem import Body, Face, Problem, Traction, mean_pressure
from solver.problem.geometry import AXES, Cartesian3D
from solver.state import DENSITY, MASS, NEW_X, NEW_Z, Particles, X, Z, empty_table, lines, views
from solver.steps.method import Method, Partition, StepBalance, refuse
from solver.steps.points import PointUpdate, StateLimits
from solver.steps.space import Gridless
from solver.steps.threads import ThreadPool

AT_FACE = 1e-6  # of a cell: nodes within it stand on a face of the grid
TOGETHER = 1e-3  # of a cell: nodes that begin within it are joined
# Rows of the state of elements that nodes show as means over their elements.
SHOWN = slice(DENSITY, NEW_X)


@dataclass
class LoadedEnd:
    """The end faces of a body that a traction presses on."""

    load: Traction
    faces: np.ndarray  # (k, 4) columns of the table of nodes


class ElementStepper(Method):
    """The stages of a step over one problem's meshes; ``shares`` of the elements may be done at once."""

    def __init__(self, problem: Problem, limits: StateLimits, pool: ThreadPool, shares: int):
        more = {
            "bodies without a mesh beside those with one": any(body.mesh is None for body in problem.bodies),
            "bodies of revolution": not isinstance(problem.geometry, Cartesian3D),
        }
        refuse(problem, "finite elements", more)
        self.problem, self.pool, self.shares = problem, pool, shares
        self._heating = float(problem.viscosity.heating)
        geometry = problem.geometry
        meshes = [body.mesh for body in problem.bodies if body.mesh]
        counts = np.cumsum([0, *(len(mesh.nodes) for mesh in meshes)])
        nodes = np.cumsum([0, *(body.mass.size for body in problem.bodies)])
        self.states = empty_table(int(counts[-1]), remembers=True)
        self.bodies = np.repeat(np.arange(len(meshes)), np.diff(counts))
        sizes = np.cumsum([0, *(mesh.nodes.size for mesh in meshes)])
        # Of each pair of an element and a node of it: its force, the node, the element, the mass it has.
        self.forces = np.zeros((int(sizes[-1]), AXES))
        self.node_of, self.element_of = np.zeros((2, int(sizes[-1])), np.int64)
        self.part = np.zeros(int(sizes[-1]))
        self.meshes, self.loaded = [], []
        for number, (body, mesh) in enumerate(zip(problem.bodies, meshes, strict=True)):
            first, pairs = int(counts[number]), slice(sizes[number], sizes[number + 1])
            elements, count = mesh.nodes.shape
            mass = body.density * volumes_of(mesh, body.position)
            state = views(self.states[:, first : counts[number + 1]])
            body.fill(state)
            state.mass[:] = mass
            columns = np.ascontiguousarray(mesh.nodes + nodes[number])
            forces = self.forces[pairs].reshape(elements, count, AXES)
            stiffness = problem.hourglass * _modulus(body)
            self.meshes.append(meshed(columns, first, stiffness, forces))
            self.node_of[pairs] = columns.ravel()
            self.element_of[pairs] = np.repeat(first + np.arange(elements), count)
            self.part[pairs] = (mass[:, None] * node_parts(mesh, body.position)).ravel()
            self.loaded += [
                LoadedEnd(load, end_faces(mesh, body.position, load) + int(nodes[number]))
                for load in problem.tractions
                if load.body == number
            ]
        order = np.argsort(self.node_of, kind="stable")
        begin = np.searchsorted(self.node_of[order], np.arange(nodes[-1] + 1))
        self.around = (begin, order)
        position = np.concatenate([body.position for body in problem.bodies])
        self.held = held_components(problem, position)
        self.walls = np.array(problem.faces, dtype=np.int64).reshape(3, 2) == Face.WALL
        lower = np.asarray(geometry.lower, np.float64)
        self.box = np.stack([lower, lower + np.asarray(geometry.cells) * geometry.spacing])
        self.joints = joints_of(position, TOGETHER * geometry.spacing)
        self.loads = np.zeros((position.shape[0], AXES))
        self.undriven = np.full(position.shape[0], -1)
        self.before = np.zeros(1)  # the step that ended at n, s
        lengths = np.zeros((1, self.states.shape[1]))
        self.space = Gridless(geometry.lower, geometry.spacing, geometry.cells, AXES, lengths)
        self.gradients = lines(AXES * self.states.shape[1])
        self.scratch = np.zeros((shares, NODES, AXES))
        self.points = PointUpdate(problem, limits, shares)
        self.taken = np.zeros((shares, 1))
        self.node_sums = np.zeros((shares, 5))
        self.find_operators, self.push_nodes = Bound(find_operators), Bound(push_nodes)
        self.strain_elements, self.move_nodes = Bound(strain_elements), Bound(move_nodes)
        self.show_nodes = Bound(show_nodes)

    def advance(self, partition: Partition, time: float, dt: float) -> StepBalance:
        """Take nodes and elements from n, at a time, to n+1."""
        kick = 0.5 * (float(self.before[0]) + dt)
        self.before = np.array([dt])
        self.push(partition.table, time, kick, dt)
        self.move(partition.table, self.undriven, kick, dt)
        self.strain(partition.table, time, kick, dt)
        return self.balance(kick)

    def push(self, table: np.ndarray, time: float, kick: float, dt: float) -> None:
        """The forces on the nodes at n."""
        self.taken[:], self.node_sums[:] = 0.0, 0.0
        self._load(table, time, dt)

        def push(share: int, body: int, begin: int, end: int) -> None:
            mesh, scratch, taken = self.meshes[body], self.scratch[share], self.taken[share]
            self.find_operators(mesh, table, begin, end)
            self.push_nodes(mesh, table, self.states, begin, end, kick, self._heating, scratch, taken)

        self._over_elements(push)

    def move(self, table: np.ndarray, drivers: np.ndarray, kick: float, dt: float) -> None:
        """Velocities and places at n+1; nodes with ``drivers``, columns of the table or -1, move as these do."""
        edges = np.linspace(0, self.joints[0].size - 1, self.shares + 1).astype(int)
        mesh = self.around, self.joints, self.forces
        bounds = self.held, self.walls, self.box, self.loads

        def move(share: int) -> None:
            span, sums = (edges[share], edges[share + 1]), self.node_sums[share]
            self.move_nodes(*mesh, *bounds, drivers, table, *span, kick, dt, sums)

        self.pool.run(move, range(self.shares))

    def strain(self, table: np.ndarray, time: float, kick: float, dt: float) -> None:
        """Density, stress and energy at n+1."""
        space, viscosity, states, gradients = self.space, self.problem.viscosity, self.states, self.gradients

        def strain(share: int, body: int, begin: int, end: int) -> None:
            mesh = self.meshes[body]
            found = self._heating, self.scratch[share], gradients, space.lengths, self.taken[share]
            self.strain_elements(mesh, table, states, begin, end, kick, dt, *found)
            span = mesh.first + begin, mesh.first + end
            self.points.update(space, viscosity, share, body, states, span, gradients, time + dt, dt)

        self._over_elements(strain)
        nodes = self.undriven.size
        table[X : Z + 1, :nodes] = table[NEW_X : NEW_Z + 1, :nodes]

    def material_points(self, particles: Particles, body: np.ndarray) -> tuple[Particles, np.ndarray]:
        """The elements and the index of each one's body: what a fault is about."""
        return views(self.states), self.bodies

    def show(self, table: np.ndarray) -> None:
        """Give the nodes of a table the means of the elements around them, by the mass that each has of them."""
        elements, count = (self.around, self.element_of, self.part, self.states), len(self.loads)

        def show(share: int) -> None:
            span = count * share // self.shares, count * (share + 1) // self.shares
            self.show_nodes(*elements, table, *span, SHOWN.start, SHOWN.stop)

        self.pool.run(show, range(self.shares))

    def carried(self) -> dict[str, np.ndarray]:
        """The state of the elements that passes from step to step."""
        springs = {f"springs_{number}": mesh.springs for number, mesh in enumerate(self.meshes)}
        return {"elements": self.states, "before": self.before, **springs}

    def take_over(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from what ``carried`` gave."""
        self.states[:], self.before = arrays["elements"], arrays["before"]
        for number, mesh in enumerate(self.meshes):
            mesh.springs[:] = arrays[f"springs_{number}"]

    def _load(self, table: np.ndarray, time: float, dt: float) -> None:
        """External forces on the nodes: gravity, and pressures on end faces as they stand."""
        gravity = np.array(self.problem.gravity)
        if not self.loaded and not gravity.any():
            return
        self.loads[:] = table[MASS, : len(self.loads), None] * gravity
        for loaded in self.loaded:
            load = loaded.load
            pressure = mean_pressure(load, time, time + dt)
            if pressure:
                areas = face_areas(loaded.faces, table[X : Z + 1].T, load.axis)
                outward = 1.0 if load.side else -1.0
                np.add.at(self.loads[:, load.axis], loaded.faces.ravel(), -outward * pressure * areas.ravel())

    def balance(self, kick: float) -> StepBalance:
        """What the step exchanged with faces, loads and springs."""
        tally = self.points.tally()
        # A mesh moves with the matter, and may leave the box.
        tally = tally._replace(convected=tally.signal, outside=0.0)
        sums = self.node_sums.sum(axis=0)
        impulse = sums[IMPULSE : IMPULSE + 3] + self.loads.sum(axis=0) * kick
        removed = float(sums[HELD] + self.taken.sum())
        return StepBalance(impulse, removed, 0.0, float(sums[WORK]), 0, 0, tally)

    def _over_elements(self, call: Callable[[int, int, int, int], None]) -> None:
        """A call over each share of the elements of each body."""

        def work(share: int) -> None:
            for body, mesh in enumerate(self.meshes):
                count = mesh.nodes.shape[0]
                call(share, body, count * share // self.shares, count * (share + 1) // self.shares)

        self.pool.run(work, range(self.shares))


def joints_of(position: np.ndarray, within: float) -> tuple[np.ndarray, np.ndarray]:
    """Nodes that stand together, as (start, nodes): those of joint j are nodes[start[j]:start[j + 1]]."""
    place = np.rint(position / within).astype(np.int64)
    _, joint = np.unique(place, axis=0, return_inverse=True)
    order = np.argsort(joint.ravel(), kind="stable")
    return np.searchsorted(joint.ravel()[order], np.arange(joint.max() + 2)), order


def held_components(problem: Problem, position: np.ndarray) -> np.ndarray:
    """The components of the velocity that closed faces hold at nodes that stand on them, (n, 3), 0 or 1."""
    geometry = problem.geometry
    held = np.zeros(position.shape, np.uint8)
    for axis in range(3):
        for side, face in enumerate(problem.faces[axis]):
            if face not in (Face.FIXED, Face.SYMMETRIC) or not geometry.cells[axis]:
                continue
            wall = geometry.lower[axis] + side * geometry.cells[axis] * geometry.spacing
            on = np.abs(position[:, axis] - wall) <= AT_FACE * geometry.spacing
            if face == Face.SYMMETRIC:
                held[on, axis] = 1
                continue
            held[on & problem.clamp.holds(position, axis)] = 1
    return held


def _modulus(body: Body) -> float:
    """The longitudinal modulus of matter at rest, Pa."""
    eos = body.matter.eos
    bulk: float = reference_density(eos) * reference_sound_speed(eos) ** 2
    return bulk + 4.0 / 3.0 * body.matter.shear_modulus
