"""The view of a plugging: projectile, plate and plug, and which matter of the plate hangs together.

Matter that has failed joins nothing. Particles of the plate that have not failed hang together where their cells are
the same or neighbours, as in the measurement of a hole. The *attached* plate hangs together with its rim; the plug is
the heaviest other piece. To it belongs the failed matter of the plate in its cells and in neighbouring ones that flies
with it, faster than half of its velocity.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from studies.measurements import RESOLUTION_IN_CELLS, Reading
from studies.measurements._cloud import connected
from studies.measurements._impact import rim_of

# Of the mass of plate that the projectile covers: a lighter piece is a chip and no plug.
LEAST_PLUG = 0.1
FLYING_WITH = 0.5  # of the plug's velocity
RING = (0.75, 1.25)  # of the plate about its hole, in projectile diameters from the axis: deflection and velocity
OPEN = 0.9  # of the projectile's radius: a hole of which no attached matter is nearer to the axis lets it pass
LAYER = 0.1  # of the thickness, a cell at least: matter that began so near to a face is that face
NO_PLUG = "no_plug"


@dataclass(frozen=True)
class PlugView:
    """Living particles of whole bodies about the line of flight."""

    radius: np.ndarray  # (n,) from the axis, m
    depth: np.ndarray  # (n,) along the flight from the plate's original front face, m
    origin: np.ndarray  # (n,) that depth at the start, m
    velocity: np.ndarray  # (n,) along the flight, m/s
    mass: np.ndarray  # (n,) kg, of the whole body
    projectile: np.ndarray  # (n,) whether it is matter of the projectile
    attached: np.ndarray  # (n,) whether it is plate that has not failed and hangs together with the rim
    core: np.ndarray  # (n,) whether it is the piece of the plug that has not failed
    plug: np.ndarray  # (n,) the same with the failed matter that flies with it
    cell: float  # m
    width: float  # of a particle of the plate across the flight, initially, m
    density: float  # of the plate, undisturbed, kg/m3
    thickness: float  # of the plate, m
    plate_radius: float  # m
    projectile_diameter: float  # m
    # From the axis, m: farther out stand nodes of elements, more than a cell apart.
    particles_to: float = math.inf

    @property
    def resolution(self) -> float:
        """Standard uncertainty of a length that one run cannot see, m."""
        return RESOLUTION_IN_CELLS * self.cell

    @property
    def layer(self) -> float:
        """Height of a face of the plate, m."""
        return max(LAYER * self.thickness, self.cell)

    @property
    def covered_mass(self) -> float:
        """Mass of the plate that a projectile covers, kg."""
        area = 0.25 * math.pi * self.projectile_diameter**2
        return self.density * area * self.thickness

    @property
    def has_plug(self) -> bool:
        """Whether a plug is free of the plate."""
        return bool(self.mass[self.core].sum() > LEAST_PLUG * self.covered_mass)

    def ring(self) -> np.ndarray:
        """(n,) whether it is attached plate in the ring about the hole."""
        low, high = (share * self.projectile_diameter for share in RING)
        inside: np.ndarray = self.attached & (self.radius > low) & (self.radius < high)
        return inside

    def is_open(self) -> bool:
        """Whether the attached plate has a hole that lets the projectile pass."""
        innermost = np.min(self.radius[self.attached], initial=math.inf)
        return bool(innermost > OPEN * 0.5 * self.projectile_diameter)


def mean_velocity(view: PlugView, which: np.ndarray) -> float:
    """Mass-weighted mean of the axial velocity of some particles (n, bool), m/s; NaN of none."""
    mass = view.mass[which]
    return float((mass * view.velocity[which]).sum() / mass.sum()) if mass.size else math.nan


def without_plug() -> Reading:
    """The reading of what only a plug has."""
    return Reading(math.nan, flags=(NO_PLUG,))


def view(setting: Any, snapshot: Any) -> PlugView:
    """The view of a snapshot (``solver.state.Snapshot``) in an ``ImpactSetting``."""
    from solver.geometry import impact_axis

    problem, particles = setting.problem, snapshot.particles
    living = np.flatnonzero(particles.alive)
    axis = impact_axis(problem.geometry)
    position, velocity = particles.position[living], particles.velocity[living, axis]
    mass = particles.mass[living] * (2.0 * math.pi / setting.sector)
    plane = position[:, :axis]
    names = [body.name for body in problem.bodies]
    body = problem.bodies[names.index(setting.target)]
    plate = snapshot.body[living] != names.index("projectile")
    origins = np.concatenate([each.position[:, axis] for each in problem.bodies])
    whole = plate & (particles.damage[living] < 1.0)
    cell = np.floor((position - problem.geometry.lower) / problem.geometry.spacing)
    cell = np.where(problem.geometry.cells > 0, cell, 0.0).astype(np.int64)
    rim = rim_of(setting, plane, position[:, axis], plate)
    rim |= _held_by_elements(problem.bodies[0].mesh, particles.number[living], rim & whole, whole)
    attached, core = _pieces(cell, mass, whole, rim)
    return PlugView(
        radius=np.sqrt((plane**2).sum(axis=1)),
        depth=position[:, axis],
        origin=origins[particles.number[living]],
        velocity=velocity,
        mass=mass,
        projectile=~plate,
        attached=attached,
        core=core,
        plug=core | _flying_with(cell, mass, velocity, core, plate & ~whole),
        cell=problem.geometry.spacing,
        width=body.spacing[0],
        density=body.density,
        thickness=setting.thickness,
        plate_radius=setting.radius,
        projectile_diameter=setting.projectile_diameter,
        particles_to=float(body.position[:, 0].max()) if problem.bodies[0].mesh else math.inf,
    )


def _held_by_elements(mesh: Any, number: np.ndarray, rim: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """Nodes of the first body's mesh that hang together with the rim through its elements, among particles (n, bool).

    ``number`` (n,) are those of the particles; an element hangs together where none of its nodes has failed.
    """
    held = np.zeros(number.size, bool)
    if mesh is None:
        return held
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    nodes = int(mesh.nodes.max()) + 1
    column = np.flatnonzero(number < nodes)
    by_node = column[np.argsort(number[column])]
    sound = mesh.nodes[whole[by_node][mesh.nodes].all(axis=1)]
    pairs = np.repeat(sound[:, 0], sound.shape[1]), sound.ravel()
    graph = coo_array((np.ones(sound.size, bool), pairs), shape=(nodes, nodes))
    piece = connected_components(graph, directed=False)[1]
    held[by_node] = np.isin(piece, piece[rim[by_node]])
    return held


def _pieces(cell: np.ndarray, mass: np.ndarray, whole: np.ndarray, rim: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which of the particles with a mass (n,) in cells (n, 3) are attached plate, and which are the plug (n, bool).

    ``whole`` (n, bool) is the plate that has not failed, ``rim`` its edge.
    """
    attached, core = np.zeros(whole.size, bool), np.zeros(whole.size, bool)
    piece = connected(cell[whole])
    attached[whole] = np.isin(piece, piece[rim[whole]])
    free = ~attached[whole]
    if free.any():
        heaviest = np.argmax(np.bincount(piece[free], mass[whole][free]))
        core[whole] = piece == heaviest
    return attached, core


def _flying_with(
    cell: np.ndarray, mass: np.ndarray, velocity: np.ndarray, core: np.ndarray, failed: np.ndarray
) -> np.ndarray:
    """Which failed particles (n, bool) stand in the cells of the plug or in neighbours of these and fly with it."""
    mine = np.zeros(core.size, bool)
    if not core.any() or not failed.any():
        return mine
    from scipy import ndimage

    both = cell[core | failed]
    low = both.min(axis=0)
    near = np.zeros(both.max(axis=0) - low + 1, bool)
    near[tuple((cell[core] - low).T)] = True
    near = ndimage.binary_dilation(near, np.ones((3, 3, 3), bool))
    speed = (mass[core] * velocity[core]).sum() / mass[core].sum()
    mine[failed] = near[tuple((cell[failed] - low).T)] & (velocity[failed] > FLYING_WITH * speed)
    return mine
