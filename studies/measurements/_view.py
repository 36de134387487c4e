"""What measurements look at: a state in cylindrical coordinates, and the edges of matter in it.

An edge stands where a density, averaged over one cell, falls to half of its undisturbed value. The average counts each
particle over its own width, so the edge moves continuously when particles do: positions are finer than a cell, and one
stray particle does not move them.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import ndimage

from studies.measurements import RESOLUTION_IN_CELLS

SECTOR = math.radians(10.0)  # width of the sectors in which a three-dimensional hole is measured
HALF = 0.5  # of the undisturbed density: an edge
SAMPLES_PER_CELL = 16  # of a profile; its crossing is interpolated between samples


@dataclass(frozen=True)
class View:
    """Living particles about the line of flight, and the numbers of the set-up."""

    radius: np.ndarray  # (n,) m
    depth: np.ndarray  # (n,) along the flight from the original surface, m
    mass: np.ndarray  # (n,) kg per radian of the sector below
    speed: np.ndarray  # (n,) m/s
    sector: np.ndarray  # (n,) index of the azimuthal sector
    sectors: int
    target: np.ndarray  # (n,) whether the particle belongs to the target
    attached: np.ndarray  # (n,) whether it touches, through the grid, the rim of the target
    attached_target: np.ndarray  # (n,) the same through particles of the target alone
    cell: float  # m
    radial_width: float  # of a particle, m
    axial_width: float  # of a particle, m
    density: float  # of the target, undisturbed, kg/m3
    thickness: float  # of the target, m
    target_radius: float  # m
    projectile_diameter: float  # m

    @property
    def resolution(self) -> float:
        """Standard uncertainty of a length that one run cannot see, m."""
        return RESOLUTION_IN_CELLS * self.cell


def view(setting: Any, snapshot: Any) -> View:
    """The view of a snapshot (``solver.state.Snapshot``) in a scenario's ``Setting``."""
    from solver.geometry import impact_axis

    problem, particles = setting.problem, snapshot.particles
    living = particles.alive == 1
    position = particles.position[living]
    axis = impact_axis(problem.geometry)
    plane = position[:, :2] if axis == 2 else position[:, :1]
    radius = np.sqrt((plane**2).sum(axis=1))
    sector, sectors = _sectors(setting, plane)
    names = [body.name for body in problem.bodies]
    target = snapshot.body[living] == names.index(setting.target)
    body = problem.bodies[names.index(setting.target)]
    rim = target & (_from_axis(plane) > setting.radius - 2.0 * problem.geometry.spacing)
    return View(
        radius=radius,
        depth=position[:, axis],
        mass=particles.mass[living] * (sectors / setting.sector),
        speed=np.sqrt((particles.velocity[living] ** 2).sum(axis=1)),
        sector=sector,
        sectors=sectors,
        target=target,
        attached=_touching(problem.geometry, position, np.ones_like(target), rim),
        attached_target=_touching(problem.geometry, position, target, rim),
        cell=problem.geometry.spacing,
        radial_width=body.spacing[0],
        axial_width=body.spacing[axis],
        density=body.density,
        thickness=setting.thickness,
        target_radius=setting.radius,
        projectile_diameter=setting.projectile_diameter,
    )


def _from_axis(plane: np.ndarray) -> np.ndarray:
    """Distance in which a target has its half width: from the axis if round, from the middle planes if square."""
    distance: np.ndarray = np.abs(plane).max(axis=1)
    return distance


def _sectors(setting: Any, plane: np.ndarray) -> tuple[np.ndarray, int]:
    if plane.shape[1] == 1:
        return np.zeros(plane.shape[0], np.int64), 1
    sectors = max(1, round(setting.sector / SECTOR))
    angle = np.arctan2(plane[:, 1], plane[:, 0])
    index = np.clip((angle / setting.sector * sectors).astype(np.int64), 0, sectors - 1)
    return index, sectors


def _touching(
    geometry: Any, position: np.ndarray, among: np.ndarray, seed: np.ndarray
) -> np.ndarray:
    """Which particles hang together with the seed: two touch when their cells are the same or neighbours.

    That is when they share a node, which is all that makes them one body for the solver.
    """
    found = np.zeros(among.size, bool)
    if not (among & seed).any():
        return found
    cell = ((position - geometry.lower) / geometry.spacing).astype(np.int64)
    cell = np.clip(cell, 0, np.maximum(np.asarray(geometry.cells) - 1, 0))
    shape = tuple(int(max(n, 1)) for n in geometry.cells)
    occupied = np.zeros(shape, bool)
    occupied[tuple(cell[among].T)] = True
    label, _ = ndimage.label(occupied, structure=np.ones((3, 3, 3), bool))
    labels = label[tuple(cell.T)]
    found[among] = np.isin(labels[among], np.unique(labels[among & seed]))
    return found


def edge_from_outside(
    place: np.ndarray,
    weight: np.ndarray,
    *,
    width: float,
    window: float,
    start: float,
    stop: float,
    nominal: Any,
) -> float:
    """Walk from ``start`` down to ``stop`` and return where matter ends, NaN where it never does.

    ``place`` and ``weight`` (n,) are particles spread evenly over ``width``; ``nominal(a, b)`` is the undisturbed
    weight between two places. Matter ends where the weight within ``window`` falls to half of the nominal one.
    """
    samples = max(2, math.ceil((start - stop) / window * SAMPLES_PER_CELL))
    centre = np.linspace(start, stop, samples)
    share = _share_of_nominal(place, weight, width, window, centre, nominal)
    below = np.flatnonzero(share < HALF)
    if not below.size:
        return math.nan
    first = int(below[0])
    return float(start) if first == 0 else _crossing(centre, share, first)


def edge_from_inside(
    place: np.ndarray,
    weight: np.ndarray,
    *,
    width: float,
    window: float,
    start: float,
    stop: float,
    nominal: Any,
) -> float:
    """Walk from ``stop`` up to ``start`` and return where matter begins; ``start`` where it never does.

    As ``edge_from_outside``, from the other end: what is empty beyond the edge does not count. NaN where matter
    stands at ``stop`` itself.
    """
    samples = max(2, math.ceil((start - stop) / window * SAMPLES_PER_CELL))
    centre = np.linspace(start, stop, samples)
    share = _share_of_nominal(place, weight, width, window, centre, nominal)
    solid = np.flatnonzero(share >= HALF)
    if not solid.size:
        return float(start)
    last = int(solid[-1])
    return math.nan if last + 1 == samples else _crossing(centre, share, last + 1)


def _share_of_nominal(
    place: np.ndarray,
    weight: np.ndarray,
    width: float,
    window: float,
    centre: np.ndarray,
    nominal: Any,
) -> np.ndarray:
    """Weight within a window about each centre, over the undisturbed one; nothing counts below the last centre."""
    low, high = np.maximum(centre - 0.5 * window, centre[-1]), centre + 0.5 * window
    filled = _cumulated(place, weight, width, high) - _cumulated(place, weight, width, low)
    share: np.ndarray = filled / nominal(low, high)
    return share


def _crossing(centre: np.ndarray, share: np.ndarray, below: int) -> float:
    """Where the share falls to half, between the sample ``below`` and the one before it."""
    part = (share[below - 1] - HALF) / (share[below - 1] - share[below])
    return float(centre[below - 1] + part * (centre[below] - centre[below - 1]))


def _cumulated(place: np.ndarray, weight: np.ndarray, width: float, at: np.ndarray) -> np.ndarray:
    """Weight below each place in ``at``, particles spread evenly over their width."""
    if not place.size:
        return np.zeros_like(at)
    knots = np.concatenate([place - 0.5 * width, place + 0.5 * width])
    slopes = np.concatenate([weight, -weight]) / width
    order = np.argsort(knots, kind="stable")
    knots = knots[order]
    slope = np.cumsum(slopes[order])
    heights = np.concatenate([[0.0], np.cumsum(slope[:-1] * np.diff(knots))])
    return np.interp(at, knots, heights, left=0.0, right=float(weight.sum()))


def overlap(centre: np.ndarray, width: float, low: float, high: float) -> np.ndarray:
    """Share of each particle, spread evenly over ``width``, that lies between two places."""
    inside = np.minimum(centre + 0.5 * width, high) - np.maximum(centre - 0.5 * width, low)
    return np.clip(inside / width, 0.0, 1.0)


def equal_area_diameter(radii: np.ndarray) -> float:
    """Diameter of the circle with the area of a hole given by its radius in equal sectors."""
    return 2.0 * math.sqrt(float(np.mean(radii**2)))


def azimuthal_spread(radii: np.ndarray) -> float:
    """Standard error of the mean diameter from the scatter over sectors, 0 for a body of revolution."""
    if radii.size < 2:
        return 0.0
    return float(2.0 * np.std(radii, ddof=1) / math.sqrt(radii.size))


def radii_by_sector(
    seen: View, keep: np.ndarray, weight: np.ndarray, areal_density: float
) -> np.ndarray:
    """Edge radius of kept matter in each sector, walking inwards from the rim (m); NaN where there is no edge.

    ``weight`` (n,) is the mass per radian that counts, ``areal_density`` (kg/m2) the undisturbed one.
    """
    radii = np.empty(seen.sectors)
    for sector in range(seen.sectors):
        mine = keep & (seen.sector == sector)
        radii[sector] = edge_from_outside(
            seen.radius[mine],
            weight[mine],
            width=seen.radial_width,
            window=seen.cell,
            start=seen.target_radius - seen.cell,
            stop=0.0,
            nominal=lambda low, high: 0.5 * areal_density * (high**2 - low**2),
        )
    return radii


def contained(seen: View, radii: np.ndarray) -> bool:
    """Whether an opening stays clear of the rim."""
    return bool(np.nanmax(radii) < seen.target_radius - 3.0 * seen.cell)
