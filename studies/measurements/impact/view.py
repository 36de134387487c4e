"""The view of an impact: a state in cylindrical coordinates about its hole."""

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from studies.measurements import OnGrid
from studies.measurements._settings import ImpactSetting
from studies.measurements.impact.edges import overlap

if TYPE_CHECKING:
    from solver.problem import Body
    from solver.problem.geometry import Axisymmetric, Cartesian3D
    from solver.state import Snapshot

SECTOR = math.radians(10.0)  # width of the sectors in which a three-dimensional hole is measured
OPEN = 0.5  # of the nominal areal density, below which a cell is open: the edge of a hole
# Particles lose contact when they are drawn more than a cell apart: at a stretch of two, where two fill a cell. A plate
# that is stretched to twice its size in both directions has a quarter of its areal density: what is denser is a plate
# and no numerical film.
FILM = 0.25
MOUTH = 2.0  # cells below the original surface, in which the mouth of a crater is looked for


@dataclass(frozen=True, eq=False)
class ImpactView(OnGrid):
    """Living particles about the line of flight, and the numbers of the set-up.

    An oblique shot makes its hole beside the first touch, and its debris beside the middle: particles stand about the
    middle of the hole. Matter counts by its undisturbed volume: a particle of another metal has the mass that its
    volume of the target would have.
    """

    radius: np.ndarray  # (n,) m
    depth: np.ndarray  # (n,) along the target's normal from the original surface, m
    mass: np.ndarray  # (n,) kg per radian of the sector below, at the target's density
    speed: np.ndarray  # (n,) m/s
    sector: np.ndarray  # (n,) index of the azimuthal sector
    sectors: int
    target: np.ndarray  # (n,) whether the particle belongs to the target
    attached: np.ndarray  # (n,) whether it touches, through the grid, the rim of the target
    attached_target: np.ndarray  # (n,) the same through particles of the target alone that have not failed
    cell: float  # m
    radial_width: float  # of a particle, m
    axial_width: float  # of a particle, m
    density: float  # of the target, undisturbed, kg/m3
    thickness: float  # of the target, m
    target_mass: float  # of the whole target, undisturbed, kg per radian of the sector
    target_radius: float  # from where radii begin to the nearest rim, m
    room: float  # height of the grid before the original surface, m
    back_absorbs: bool  # whether waves leave through the back of the target
    projectile_diameter: float  # m
    span: float = 2.0 * math.pi  # angle that the sectors cover, rad
    # (n,) m from the middle along the trace of an oblique flight; None at normal incidence.
    along: np.ndarray | None = None

    def about(self, place: float) -> "ImpactView":
        """The view about a place on the trace of an oblique flight (m from the middle); itself at normal incidence."""
        if self.along is None or place == 0.0:
            return self
        along = self.along - place
        aside = np.sqrt(np.maximum(self.radius**2 - self.along**2, 0.0))
        return replace(
            self,
            radius=np.hypot(along, aside),
            sector=_sector_of(np.arctan2(aside, along), self.span, self.sectors),
            along=along,
        )

    def only(self, places: np.ndarray) -> "ImpactView":
        """The view of the particles at some indices (k,)."""
        return replace(
            self, **{name: value[places] for name, value in vars(self).items() if isinstance(value, np.ndarray)}
        )


def view(setting: ImpactSetting, snapshot: "Snapshot") -> ImpactView:
    """The view of a snapshot."""
    from solver.problem.geometry import impact_axis

    problem, particles = setting.problem, snapshot.particles
    # A slice copies nothing.
    living = slice(None) if particles.alive.all() else particles.alive == 1
    position, body_of = particles.position[living], snapshot.body[living]
    axis = impact_axis(problem.geometry)
    plane = position[:, :2] if axis == 2 else position[:, :1]
    names = [body.name for body in problem.bodies]
    number = names.index(setting.target)
    target, body = body_of == number, problem.bodies[number]
    rim = rim_of(setting, plane, position[:, axis], target)
    cell = _cells(problem.geometry, position)
    attached_target = _touching(problem.geometry, cell, target & (particles.damage[living] < 1.0), rim)
    centre = np.zeros(plane.shape[1])
    # Debris from another grid, too, opens a half model beside its middle.
    is_half = axis == 2 and problem.geometry.lower[0] < 0.0
    is_oblique = (is_half and problem.arrivals is not None) or any(
        np.delete(body.velocity, axis, axis=-1).any() for body in problem.bodies
    )
    if is_oblique:
        centre = _centre_of_opening(
            plane[attached_target],
            position[attached_target, axis],
            particles.mass[living][attached_target],
            body=body,
            setting=setting,
            axis=axis,
        )
    plane = plane - centre
    sectors = 1 if axis == 1 else max(1, round(setting.sector / SECTOR))
    angle = np.zeros(len(plane)) if axis == 1 else np.arctan2(plane[:, 1], plane[:, 0])
    at_target_density = np.array([body.density / other.density for other in problem.bodies])
    return ImpactView(
        radius=np.sqrt((plane**2).sum(axis=1)),
        depth=position[:, axis],
        mass=particles.mass[living] * (sectors / setting.sector) * at_target_density[body_of],
        speed=np.sqrt((particles.velocity[living] ** 2).sum(axis=1)),
        sector=_sector_of(angle, setting.sector, sectors),
        sectors=sectors,
        target=target,
        attached=_touching(problem.geometry, cell, np.ones_like(target), rim),
        attached_target=attached_target,
        cell=problem.geometry.spacing,
        radial_width=body.spacing[0],
        axial_width=body.spacing[axis],
        density=body.density,
        thickness=setting.thickness,
        target_mass=float(body.mass.sum()) * sectors / setting.sector,
        target_radius=setting.radius - float(np.abs(centre).max()),
        room=-float(problem.geometry.lower[axis]),
        back_absorbs=any((a.body, a.axis, a.side) == (number, axis, 1) for a in problem.absorbers),
        projectile_diameter=setting.projectile_diameter,
        span=2.0 * math.pi if plane.shape[1] == 1 else setting.sector,
        along=plane[:, 0] if is_oblique else None,
    )


def _centre_of_opening(
    plane: np.ndarray, depth: np.ndarray, mass: np.ndarray, *, body: "Body", setting: ImpactSetting, axis: int
) -> np.ndarray:
    """Centroid (2,) of the largest opening in a half model (m): a hole, else the mouth of a crater, else the origin.

    ``plane`` (n, 2), ``depth`` and ``mass`` (n,) are the connected target.
    """
    cell = setting.problem.geometry.spacing
    mouth = MOUTH * cell
    share = overlap(depth, body.spacing[axis], 0.0, mouth)
    for weight, thickness in ((mass, setting.thickness), (mass * share, mouth)):
        areal_density = body.density * thickness
        least = FILM if thickness == setting.thickness else OPEN
        centre = _centre_of_hole(
            plane, weight, areal_density=areal_density, radius=setting.radius, cell=cell, least=least
        )
        if centre is not None:
            return centre
    return np.zeros(2)


def _centre_of_hole(
    plane: np.ndarray, mass: np.ndarray, *, areal_density: float, radius: float, cell: float, least: float
) -> np.ndarray | None:
    """Centroid (2,) of the largest opening in a half model (m); None where there is none within the rim.

    ``plane`` (n, 2) and ``mass`` (n,) are the connected plate, square with half width ``radius``, above y = 0.
    Somewhere in it stands less than a part ``least`` of the areal density.
    """
    from scipy import ndimage  # 0.1 s, which only a process that measures pays

    count = int(radius / cell + 1e-9)  # whole cells, whatever the round-off
    edges = cell * np.arange(-count, count + 1)
    mass_in_cell, _, _ = np.histogram2d(plane[:, 0], plane[:, 1], bins=(edges, edges[count:]), weights=mass)
    label, _ = ndimage.label(mass_in_cell < OPEN * areal_density * cell**2)
    size = np.bincount(label.ravel())
    size[0] = 0
    size[np.concatenate([label[0], label[-1], label[:, -1]])] = 0  # open to the rim
    if not size.any():
        return None
    inside = label == np.argmax(size)
    if mass_in_cell[inside].min() > least * areal_density * cell**2:
        return None
    column = np.nonzero(inside)[0]
    return np.array([edges[0] + cell * (column.mean() + 0.5), 0.0])


def rim_of(setting: ImpactSetting, plane: np.ndarray, depth: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Particles of the target where its rim stands, which may drift, a cell in front and behind included."""
    cell = setting.problem.geometry.spacing
    # A target has its half width from the axis if round, from the middle planes if square.
    far = target & (np.abs(plane).max(axis=1) > setting.radius - 2.0 * cell)
    if not far.any():
        return far
    places = np.sort(depth[far])
    reach = setting.thickness + 2.0 * cell
    inside = np.searchsorted(places, places + reach, side="right") - np.arange(places.size)
    front = places[np.argmax(inside)]
    return far & (depth >= front) & (depth <= front + reach)


def _sector_of(angle: np.ndarray, span: float, sectors: int) -> np.ndarray:
    """Index (n,) of the sector at an angle (rad)."""
    return np.clip((angle / span * sectors).astype(np.int64), 0, sectors - 1)


def hanging_together(
    geometry: "Axisymmetric | Cartesian3D", position: np.ndarray, among: np.ndarray, seed: np.ndarray
) -> np.ndarray:
    """Which particles at positions (n, 3), ``among`` some, hang together with a seed (n, bool) as for the solver."""
    return _touching(geometry, _cells(geometry, position), among, seed)


def _cells(geometry: "Axisymmetric | Cartesian3D", position: np.ndarray) -> np.ndarray:
    """Index (n,) of each particle's cell among all of them, the last axis fastest; outside the grid, of the nearest."""
    cell = np.zeros(position.shape[0], np.int64)
    for axis, count in enumerate(geometry.cells):
        if count > 1:
            place = (position[:, axis] - geometry.lower[axis]) / geometry.spacing
            cell = cell * count + np.clip(place, 0.0, count - 1).astype(np.int64)
    return cell


def _touching(
    geometry: "Axisymmetric | Cartesian3D", cell: np.ndarray, among: np.ndarray, seed: np.ndarray
) -> np.ndarray:
    """Which particles hang together with the seed: two touch when their cells are the same or neighbours.

    That is when they share a node, which is all that makes them one body for the solver. Matter that has failed bears
    no tension and holds nothing, so that a plate or a wall is looked for without it; the floor of a crater includes it.
    """
    touching = np.zeros(among.size, bool)
    if not (among & seed).any():
        return touching
    occupied = np.zeros(np.maximum(geometry.cells, 1), bool)
    occupied.reshape(-1)[cell[among]] = True
    from scipy import ndimage

    occupied = occupied.squeeze()
    label, pieces = ndimage.label(occupied, structure=np.ones((3,) * occupied.ndim, bool))
    labels = label.reshape(-1)[cell]
    reached = np.zeros(pieces + 1, bool)
    reached[labels[among & seed]] = True
    touching[among] = reached[labels[among]]
    return touching


def connected(cell: np.ndarray) -> np.ndarray:
    """Number (n,) of the connected piece of each particle, by its cell (n, 3): cells touch at corners too.

    The work grows with the number of particles, however far apart they are.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not cell.size:
        return np.zeros(0, np.int64)
    cell = cell - cell.min(axis=0) + 1
    size = cell.max(axis=0) + 2
    stride = np.array([size[1] * size[2], size[2], 1])
    occupied, of = np.unique(cell @ stride, return_inverse=True)
    pairs = []
    # Half of the neighbours: the others see the pair from their side.
    for offset in [step for step in product((-1, 0, 1), repeat=3) if step > (0, 0, 0)]:
        wanted = occupied + np.array(offset) @ stride
        place = np.searchsorted(occupied, wanted)
        found = np.flatnonzero(occupied[np.minimum(place, occupied.size - 1)] == wanted)
        pairs.append(np.stack([found, place[found]]))
    first, second = np.concatenate(pairs, axis=1)
    graph = coo_array((np.ones(first.size, bool), (first, second)), shape=(occupied.size,) * 2)
    piece: np.ndarray = connected_components(graph, directed=False)[1]
    return piece[of.ravel()].astype(np.int64)
