"""The view of a debris cloud: all matter of an impact about its axis, and which of it is plate, behind or before it.

What has departed from the grid belongs to it, flown straight from there (``solver.state.Departed``). What lies beyond
the plane of the plate's original back surface is *behind* the plate, what lies before that of its original front
surface is *before* it; between the planes it is neither. That holds for all matter, the lips of the hole included:
what hangs together with the plate is decided by the mesh. What *came off* does not hang together with the target's rim
through cells that hold the target's matter, as in the measurement of a hole; half of the difference that it makes to
count this alone is the part of the definition.

A share of the mass exceeds a velocity x when that share of the mass has more: particles are taken in ascending order,
each stands where half of its own mass lies below, and x is interpolated between them. A share of the mass exceeds a
place when it lies farther out, each particle spread evenly over its initial width.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from studies.measurements import RESOLUTION_IN_CELLS, Reading
from studies.measurements._impact import place_holding, rim_of
from studies.values.results import DEFINITION

# Pieces are flagged where the grid still joins flying matter to the plate: more than a hundredth of the mass behind,
# faster than a tenth of the impact speed.
JOINED, FLYING = 0.01, 0.1
NOT_SEPARATED, NOTHING_BEHIND, FEW_PARTICLES = "not_separated", "nothing_behind", "few_particles"

HALF = 0.5  # of the difference between two definitions, or between two neighbours: a standard uncertainty


@dataclass(frozen=True)
class CloudView:
    """Particles of whole bodies about the axis of an impact, those that departed included."""

    radius: np.ndarray  # (n,) from the axis, m
    depth: np.ndarray  # (n,) along the flight from the plate's original front surface, m
    axial_velocity: np.ndarray  # (n,) m/s
    transverse_velocity: np.ndarray  # (n,) not negative, m/s
    mass: np.ndarray  # (n,) kg, of the whole body
    energy: np.ndarray  # (n,) specific internal energy, J/kg
    temperature: np.ndarray  # (n,) K
    projectile: np.ndarray  # (n,) whether it is matter of the projectile
    plate: np.ndarray  # (n,) whether it is target that hangs together with the rim
    fragment: np.ndarray  # (n,) number of the connected piece of what came off, -1 of the plate
    copies: np.ndarray  # (n,) pieces that its piece of the model stands for in the whole body
    cell: float  # m
    width: float  # of a particle, initially, m
    thickness: float  # of the plate, m
    speed: float  # of the impact, m/s
    melting: tuple[Any, Any]  # of projectile and target: studies.scenarios.Melting, or the flag that says why not

    @property
    def resolution(self) -> float:
        """Standard uncertainty of a length that one run cannot see, m."""
        return RESOLUTION_IN_CELLS * self.cell

    def behind(self, off: float = 0.0) -> np.ndarray:
        """(n,) whether it is farther than ``off`` (m) behind the back surface."""
        beyond: np.ndarray = self.depth > self.thickness + off
        return beyond

    def before(self, off: float = 0.0) -> np.ndarray:
        """(n,) whether it is farther than ``off`` (m) before the front surface."""
        beyond: np.ndarray = self.depth < -off
        return beyond


def view(setting: Any, snapshot: Any) -> CloudView:
    """The view of a snapshot (``solver.state.Snapshot``) in a ``CloudSetting``."""
    from solver.debris import flown
    from solver.geometry import impact_axis

    problem, particles, departed = setting.problem, snapshot.particles, snapshot.departed
    living = particles.alive == 1
    axis = impact_axis(problem.geometry)

    def whole(name: str) -> np.ndarray:
        return np.concatenate([getattr(particles, name)[living], getattr(departed, name)])

    position = np.concatenate([particles.position[living], flown(problem, departed, snapshot.time)])
    velocity, body = whole("velocity"), np.concatenate([snapshot.body[living], departed.body])
    across = [0] if axis == 1 else [0, 1]
    target = body == [each.name for each in problem.bodies].index(setting.target)
    on_grid = np.arange(body.size) < living.sum()
    rim = rim_of(setting, position[:, across], position[:, axis], target & on_grid)
    cell = np.floor((position - problem.geometry.lower) / problem.geometry.spacing)
    cell = np.where(problem.geometry.cells > 0, cell, 0.0).astype(np.int64)
    plate = np.zeros(body.size, bool)
    piece = connected(cell[target])
    plate[target] = np.isin(piece, np.unique(piece[rim[target]]))
    fragment = np.full(body.size, -1)
    fragment[~plate] = connected(cell[~plate])
    return CloudView(
        radius=np.sqrt((position[:, across] ** 2).sum(axis=1)),
        depth=position[:, axis],
        axial_velocity=velocity[:, axis],
        transverse_velocity=np.sqrt((np.delete(velocity, axis, axis=1) ** 2).sum(axis=1)),
        mass=whole("mass") * (2.0 * np.pi / setting.sector),
        energy=whole("energy"),
        temperature=whole("temperature"),
        projectile=~target,
        plate=plate,
        fragment=fragment,
        copies=_copies(problem, axis, cell, fragment),
        cell=problem.geometry.spacing,
        width=max(each.spacing[axis] for each in problem.bodies),
        thickness=setting.thickness,
        speed=setting.speed,
        melting=setting.melting,
    )


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
    for offset in [each for each in product((-1, 0, 1), repeat=3) if each > (0, 0, 0)]:
        wanted = occupied + np.array(offset) @ stride
        place = np.searchsorted(occupied, wanted)
        found = np.flatnonzero(occupied[np.minimum(place, occupied.size - 1)] == wanted)
        pairs.append(np.stack([found, place[found]]))
    first, second = np.concatenate(pairs, axis=1)
    graph = coo_array((np.ones(first.size, bool), (first, second)), shape=(occupied.size,) * 2)
    piece: np.ndarray = connected_components(graph, directed=False)[1]
    return piece[of.ravel()].astype(np.int64)


def _copies(problem: Any, axis: int, cell: np.ndarray, fragment: np.ndarray) -> np.ndarray:
    """Pieces (n,) of the whole body for which that of a particle stands: twice for each plane that it does not touch.

    A body of revolution has no planes: its pieces are rings.
    """
    from solver.problem import Face

    copies = np.ones(fragment.size)
    if axis == 1:
        return copies
    for across in (0, 1):
        if problem.faces[across][0] == Face.SYMMETRIC:
            touching = np.isin(fragment, fragment[cell[:, across] == 0])
            copies[~touching] *= 2.0
    return copies


def exceeded(values: np.ndarray, mass: np.ndarray, share: float, width: float = 0.0) -> float:
    """The value that a share of the mass exceeds; ``values`` and ``mass`` (n,), places are spread over a ``width``."""
    if width:
        return place_holding(values, mass, width, (1.0 - share) * float(mass.sum()))
    order = np.lexsort((mass, values))
    middles = np.cumsum(mass[order]) - HALF * mass[order]
    return float(np.interp((1.0 - share) * mass.sum(), middles, values[order]))


def exceeded_reading(
    view: CloudView, values: np.ndarray, share: float, among: np.ndarray, *, is_length: bool = False
) -> Reading:
    """The reading of a value that a share of the mass of some particles (n, bool) exceeds; ``values`` (n,).

    Its parts: half of what one particle more or less changes, a cell for a length, and what came off alone.
    """
    if not among.any():
        return Reading(np.nan, flags=(NOTHING_BEHIND,))
    width = view.width if is_length else 0.0

    def of(which: np.ndarray, share: float) -> float:
        return exceeded(values[which], view.mass[which], share, width)

    value, loose = of(among, share), among & ~view.plate
    step = float(view.mass[among].max() / view.mass[among].sum())
    few = (FEW_PARTICLES,) if min(share, 1.0 - share) < step else ()
    near = [of(among, min(max(share + side * step, 1e-9), 1.0)) for side in (-1.0, 1.0)]
    parts = {"sampling": HALF * abs(near[0] - near[1])}
    if is_length:
        parts["resolution"] = view.resolution
    if loose.any():
        parts[DEFINITION] = HALF * abs(of(loose, share) - value)
    return Reading(value, parts, few)


def flags(view: CloudView) -> tuple[str, ...]:
    """``not_separated`` where the grid still joins flying matter to the plate."""
    behind = view.behind()
    joined = behind & view.plate & (view.axial_velocity > FLYING * view.speed)
    is_joined = view.mass[joined].sum() > JOINED * view.mass[behind].sum()
    return (NOT_SEPARATED,) if is_joined else ()


def total_reading(view: CloudView, of: np.ndarray, inside: Callable[[CloudView, float], np.ndarray]) -> Reading:
    """The reading of a sum over the matter on one side of the plate; ``of`` (n,) is summed.

    Its parts: half of what a plane one cell farther out leaves away, and what came off alone.
    """
    within = inside(view, 0.0)
    value, farther = float(of[within].sum()), float(of[inside(view, view.resolution)].sum())
    loose = float(of[within & ~view.plate].sum())
    parts = {"resolution": HALF * abs(farther - value), DEFINITION: HALF * abs(loose - value)}
    return Reading(value, parts)
