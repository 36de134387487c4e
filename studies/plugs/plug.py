"""Plugging: projectile, plate and plug, the hole at both faces, and which matter of the plate hangs together.

Matter that has failed joins nothing. Particles of the plate that have not failed hang together where their cells are
the same or neighbours, as in the measurement of a hole. The *attached* plate hangs together with its rim; the plug is
the heaviest other piece. To it belongs the failed matter of the plate in its cells and in neighbouring ones that flies
with it, faster than half of its velocity.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from studies.measurements import History, Measurement, NoValue, OnGrid, Reading, measurement
from studies.measurements._settings import ImpactSetting
from studies.measurements.impact.edges import edge_from_outside
from studies.measurements.impact.view import connected, rim_of
from studies.quantities.measured import DEFINITION

if TYPE_CHECKING:
    from solver.problem import Mesh
    from solver.state import Snapshot

# Of the mass of plate that the projectile covers: a lighter piece is a chip and no plug.
LEAST_PLUG = 0.1
FLYING_WITH = 0.5  # of the plug's velocity
RING = (0.75, 1.25)  # of the plate about its hole, in projectile diameters from the axis: deflection and velocity
OPEN = 0.9  # of the projectile's radius: a hole of which no attached matter is nearer to the axis lets it pass
LAYER = 0.1  # of the thickness, a cell at least: matter that began so near to a face is that face


@dataclass(frozen=True)
class PlugView(OnGrid):
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
    def layer(self) -> float:
        """Height of a face of the plate, m."""
        return max(LAYER * self.thickness, self.cell)

    @property
    def has_plug(self) -> bool:
        """Whether a plug is free of the plate."""
        area = 0.25 * math.pi * self.projectile_diameter**2
        return bool(self.mass[self.core].sum() > LEAST_PLUG * (self.density * area * self.thickness))

    def ring(self) -> np.ndarray:
        """(n,) whether it is attached plate in the ring about the hole."""
        low, high = (share * self.projectile_diameter for share in RING)
        return self.attached & (self.radius > low) & (self.radius < high)

    def is_open(self) -> bool:
        """Whether the attached plate has a hole that lets the projectile pass."""
        innermost = np.min(self.radius[self.attached], initial=math.inf)
        return bool(innermost > OPEN * 0.5 * self.projectile_diameter)


def mean_velocity(view: PlugView, which: np.ndarray) -> float:
    """Mass-weighted mean of the axial velocity of some particles (n, bool), m/s; NaN of none."""
    mass = view.mass[which]
    return float((mass * view.velocity[which]).sum() / mass.sum()) if mass.size else math.nan


def view(setting: ImpactSetting, snapshot: "Snapshot") -> PlugView:
    """The view of a snapshot."""
    from solver.problem.geometry import impact_axis

    problem, particles = setting.problem, snapshot.particles
    living = np.flatnonzero(particles.alive)
    axis = impact_axis(problem.geometry)
    position, velocity = particles.position[living], particles.velocity[living, axis]
    mass = particles.mass[living] * (2.0 * math.pi / setting.sector)
    plane = position[:, :axis]
    names = [body.name for body in problem.bodies]
    body = problem.bodies[names.index(setting.target)]
    plate = snapshot.body[living] != names.index("projectile")
    origins = np.concatenate([body.position[:, axis] for body in problem.bodies])
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


def _held_by_elements(mesh: "Mesh | None", number: np.ndarray, rim: np.ndarray, whole: np.ndarray) -> np.ndarray:
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


# ---- the plug ------------------------------------------------------------------------------------

HALF = 0.5  # between two definitions: the part of the uncertainty


@measurement(
    title="Mass of the plug",
    unit="kg",
    meaning="mass of the heaviest piece of the plate that has not failed and does not hang together with the rim, and "
    "of the failed matter in its cells and neighbouring ones that is faster than half of it; no plug where the piece "
    "has less than a tenth of the mass that the projectile covers",
)
def plug_mass(view: PlugView) -> Reading:
    """The mass with the failed matter that flies with it; its wall is known to a cell."""
    if not view.has_plug:
        raise NoValue("no_plug")
    value, core = float(view.mass[view.plug].sum()), float(view.mass[view.core].sum())
    wall = math.pi * view.projectile_diameter * view.thickness
    parts = {"resolution": view.density * wall * view.resolution, DEFINITION: HALF * (value - core)}
    return Reading(value, parts)


@measurement(
    title="Velocity of the plug",
    unit="m s-1",
    meaning="mass-weighted mean axial velocity of the plug, with the failed matter that flies with it",
    version=2,
)
def plug_velocity(view: PlugView) -> Reading:
    if not view.has_plug:
        raise NoValue("no_plug")
    value = mean_velocity(view, view.plug)
    return Reading(value, {DEFINITION: HALF * abs(mean_velocity(view, view.core) - value)})


@measurement(
    title="Separation of the plug",
    unit="s",
    meaning="time of the first observation from which on a plug hangs together with the plate by no matter that has "
    "not failed",
    follows=(plug_mass.name,),
)
def plug_separation(history: History) -> Reading:
    without = np.flatnonzero(np.isnan(history.values[plug_mass.name]))
    first = int(without[-1]) + 1 if without.size else 0
    if first == history.times.size:
        raise NoValue("no_plug")
    interval = history.times[first] - history.times[max(first - 1, 0)]
    return Reading(float(history.times[first]), {"sampling": float(interval)})


# ---- the projectile ------------------------------------------------------------------------------


@measurement(
    title="Velocity of the projectile",
    unit="m s-1",
    meaning="mass-weighted mean axial velocity of the projectile at the time of the observation",
)
def projectile_velocity(view: PlugView) -> Reading:
    return Reading(mean_velocity(view, view.projectile))


@measurement(
    title="Perforated",
    unit="1",
    meaning="1 where the plate that has not failed and hangs together with the rim is nowhere nearer to the axis than "
    "0.9 radii of the projectile, and the projectile flies forward; 0 where it does not, or where it is no faster than "
    "the plate between 0.75 and 1.25 diameters from the axis; else undecided: the run ends too early",
    outcomes=("plate holds", "plate perforated"),
)
def perforated(view: PlugView) -> Reading:
    speed = mean_velocity(view, view.projectile)
    if speed <= 0.0:
        return Reading(0.0)
    if view.is_open():
        return Reading(1.0)
    if speed <= mean_velocity(view, view.ring()):
        return Reading(0.0)
    raise NoValue("undecided")


LAST = 0.1  # of the time so far: over it the velocity has to be constant
CONSTANT = 0.01  # of the impact speed


@measurement(
    title="Residual velocity",
    unit="m s-1",
    meaning="mass-weighted mean axial velocity of the projectile at the end of the run where it perforates the plate, "
    "0 where it does not; uncertain by its range over the last tenth of the run; in contact where that is more than "
    "1 % of the impact speed",
    follows=(perforated.name, projectile_velocity.name),
)
def residual_velocity(history: History) -> Reading:
    outcome, velocity = history.values[perforated.name][-1], history.values[projectile_velocity.name]
    if math.isnan(outcome):
        raise NoValue("undecided")
    if outcome == 0.0:
        return Reading(0.0)
    late = velocity[history.times >= (1.0 - LAST) * history.times[-1]]
    change = float(np.ptp(late))
    flags = ("in_contact",) if change > CONSTANT * velocity[0] else ()
    return Reading(float(velocity[-1]), {"sampling": change}, flags)


LOST = 1e-3  # of the impact speed: more than round-off and waves of one particle


@measurement(
    title="First contact",
    unit="s",
    meaning="time from which on the projectile slows down: where the line through the velocities of the first two "
    "observations that show a loss of more than 0.1 % meets the impact speed, at most two observations earlier",
    follows=(projectile_velocity.name,),
)
def first_contact(history: History) -> Reading:
    times, velocity = history.times, history.values[projectile_velocity.name]
    late = np.flatnonzero(velocity < (1.0 - LOST) * velocity[0])
    if late.size < 2 or late[0] == 0:
        raise NoValue("no_contact")
    first = int(late[0])
    slope = (velocity[first + 1] - velocity[first]) / (times[first + 1] - times[first])
    before, after = times[max(first - 2, 0)], times[first]
    onset = after + (velocity[0] - velocity[first]) / slope if slope < 0.0 else before
    return Reading(float(np.clip(onset, before, after)), {"sampling": float(after - times[first - 1])})


# ---- the plate -----------------------------------------------------------------------------------


@measurement(
    title="Dishing",
    unit="m",
    meaning="mean displacement along the flight of the plate's rear face, a tenth of the thickness or a cell, between "
    "0.75 and 1.25 projectile diameters from the axis, at the time of the observation",
)
def dishing(view: PlugView) -> Reading:
    mine = view.ring() & (view.origin > view.thickness - view.layer)
    if not mine.any():
        raise NoValue("no_plate")
    mass = view.mass[mine]
    moved = (mass * (view.depth[mine] - view.origin[mine])).sum() / mass.sum()
    return Reading(float(moved), {"resolution": view.resolution})


START = 2.0  # projectile diameters from the axis, from where on the edge of the hole is looked for inwards


def _hole(face: str, distance: Callable[[PlugView], np.ndarray]) -> Measurement:
    """The hole in the layer of a face, from the distance (n,) of particles to it at the start."""

    def read(view: PlugView) -> Reading:
        if not view.is_open():
            raise NoValue("not_perforated")
        mine = view.attached & (distance(view) < view.layer)
        areal = 2.0 * math.pi * view.density * view.layer
        start = min(START * view.projectile_diameter, min(view.plate_radius, view.particles_to) - view.cell)
        edge = edge_from_outside(
            view.radius[mine],
            view.mass[mine],
            width=view.width,
            window=view.cell,
            start=start,
            stop=0.0,
            nominal=lambda low, high: 0.5 * areal * (high**2 - low**2),
        )
        if edge >= start:
            raise NoValue("not_contained")
        return Reading(2.0 * edge, {"resolution": view.resolution})

    return Measurement(
        name=f"hole_diameter_{face}",
        title=f"Hole diameter, {face} face",
        unit="m",
        meaning=f"diameter at which the areal density of the layer at the {face} face, a tenth of the thickness or a "
        "cell, falls to half of its nominal value on the way in; of the plate that has not failed and hangs together "
        "with the rim",
        definition=read,
    )


MEASUREMENT = (
    plug_mass,
    plug_velocity,
    plug_separation,
    projectile_velocity,
    perforated,
    residual_velocity,
    first_contact,
    dishing,
    _hole("front", lambda view: view.origin),
    _hole("rear", lambda view: view.thickness - view.origin),
)
