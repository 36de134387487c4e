"""The view of a bar: its particles by their place in the initial lattice, edges, motion and energy.

An edge is that of a particle: the centre of the outermost particle of a lattice row, and half of the particle's own
width beyond. The width is that of the moment, stretched with the body: the distance to the neighbour in the row. An
undeformed bar then has exactly its length and diameter, and a uniformly stretched one exactly what it was stretched
to. In three dimensions the rows along x and along y beside the symmetry planes are taken, which end on the bar's own
radius; a slanted row of a lattice cylinder ends on a step.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from studies.measurements import RESOLUTION_IN_CELLS, Reading
from studies.values.results import LOST_PARTICLES

TWICE_THE_SHEAR = np.array([1.0, 1.0, 1.0, 2.0, 2.0, 2.0])  # six components in a double contraction


@dataclass(frozen=True)
class BarView:
    """A bar: particles, with what the set-up says of it. Heights are distances from the wall."""

    place: np.ndarray  # (n, 3) in the initial lattice: across, across, along; from 0
    position: np.ndarray  # (n, 3) x, y, height; in axisymmetry r, 0, height; m
    velocity: np.ndarray  # (n, 3) in the same order, m/s
    mass: np.ndarray  # (n,) kg, per radian in axisymmetry
    strain_energy: np.ndarray  # (n,) elastic, J/kg
    stress: np.ndarray  # (n,) along the bar, without artificial viscosity, Pa
    height: np.ndarray  # (n,) initial, m
    width: float  # of a particle across, initially, m
    cell: float  # m
    length: float  # initial, m
    diameter: float  # initial, m
    speed: float  # initial, towards the wall, m/s
    is_loaded: bool  # whether more than the wall acts on it
    references: tuple[float | None, float | None, float | None]  # length, diameter, width; m

    @property
    def resolution(self) -> float:
        """Standard uncertainty of a length that one run cannot see, m."""
        return RESOLUTION_IN_CELLS * self.cell

    @property
    def share(self) -> float:
        """Standard uncertainty of a share of the whole bar that one run cannot see: one cell of its length."""
        return RESOLUTION_IN_CELLS * self.cell / self.length


def view(setting: Any, snapshot: Any) -> BarView:
    """The view of a snapshot (``solver.state.Snapshot``) in a ``BarSetting``."""
    from solver.geometry import impact_axis

    particles = snapshot.particles
    living = np.flatnonzero(particles.alive)
    body = setting.problem.bodies[0]
    axis = impact_axis(setting.problem.geometry)
    order = [0, 2, 1] if axis == 1 else [0, 1, 2]
    return BarView(
        place=setting.place[particles.number[living]],
        position=_ordered(particles.position[living], order),
        velocity=_ordered(particles.velocity[living], order),
        mass=particles.mass[living],
        strain_energy=_strain_energy(body, particles, living),
        stress=particles.deviator[living, axis] - particles.pressure[living],
        height=np.concatenate([each.position[:, axis] for each in setting.problem.bodies])[particles.number[living]],
        width=body.spacing[0],
        cell=setting.problem.geometry.spacing,
        length=setting.length,
        diameter=setting.diameter,
        speed=setting.speed,
        is_loaded=bool(setting.problem.tractions) or any(setting.problem.gravity),
        references=setting.references,
    )


def _ordered(vectors: np.ndarray, order: list[int]) -> np.ndarray:
    """Components across, across, along the bar; the swirl of a body of revolution is none."""
    ordered = vectors[:, order].copy()
    if order[1] == 2:
        ordered[:, 1] = 0.0
    return ordered


def _strain_energy(body: Any, particles: Any, living: np.ndarray) -> np.ndarray:
    """Energy of elastic strain, J/kg: that of p = K (rho / rho0 - 1) in the volume, s : s / 4 G in the shape."""
    from solver.eos import reference_sound_speed

    ratio = particles.density[living] / body.density
    volume = reference_sound_speed(body.matter.eos) ** 2 * (np.log(ratio) - 1.0 + 1.0 / ratio)
    deviator = particles.deviator[living]
    squares = (deviator**2 * TWICE_THE_SHEAR).sum(axis=1)
    shear = body.matter.shear_modulus
    shape = squares / (4.0 * shear * particles.density[living]) if shear else np.zeros_like(volume)
    energy: np.ndarray = volume + shape
    return energy


# ---- edges ---------------------------------------------------------------------------------------


def side_edges(view: BarView) -> tuple[np.ndarray, np.ndarray]:
    """Height and radius (m) of the bar's side, layer by layer from the impact face: mean over the rows across.

    NaN for a layer whose rows have lost particles.
    """
    directions = [0, 1] if view.place[:, 1].any() else [0]
    ends = np.stack([_row_ends(view, direction) for direction in directions])
    heights: np.ndarray = ends[:, :, 2].mean(axis=0)
    radii = np.stack([end[:, direction] for direction, end in zip(directions, ends, strict=True)])
    return heights, radii.mean(axis=0)


def end_edges(view: BarView) -> tuple[float, float]:
    """Height of the impact face and of the rear (m): the lowest and the highest end of the columns along the bar.

    NaN where the bar has lost particles.
    """
    column = np.unique(view.place[:, :2], axis=0, return_inverse=True)[1].ravel()
    height = np.full((column.max() + 1, view.place[:, 2].max() + 1), math.nan)
    height[column, view.place[:, 2]] = view.position[:, 2]
    if height.shape[1] < 2:
        return math.nan, math.nan
    foot = height[:, 0] - 0.5 * (height[:, 1] - height[:, 0])
    rear = height[:, -1] + 0.5 * (height[:, -1] - height[:, -2])
    return float(np.min(foot)), float(np.max(rear))


def _row_ends(view: BarView, direction: int) -> np.ndarray:
    """Where the row along ``direction`` beside the axis ends in each layer, (layers, 3) m."""
    row = view.place[:, 1 - direction] == 0
    layer, step = view.place[row, 2], view.place[row, direction]
    points = np.full((view.place[:, 2].max() + 1, step.max() + 1, 3), math.nan)
    points[layer, step] = view.position[row]
    last = points[:, -1]
    if points.shape[1] > 1:
        ends: np.ndarray = last + 0.5 * (last - points[:, -2])
        return ends
    alone = last.copy()
    alone[:, direction] += 0.5 * view.width
    return alone


# ---- readings ------------------------------------------------------------------------------------

LOST = Reading(math.nan, flags=(LOST_PARTICLES,))
# Of what is measured against the initial motion of a bar on which its wall alone acts.
LOADED = Reading(math.nan, flags=("loaded",))


def length_of(view: BarView) -> Reading:
    """From the impact face to the rear."""
    foot, rear = end_edges(view)
    if math.isnan(rear - foot):
        return LOST
    return Reading(rear - foot, {"resolution": view.resolution})


def mushroom_of(view: BarView) -> Reading:
    """The widest layer."""
    _, radii = side_edges(view)
    if np.isnan(radii).any():
        return LOST
    return Reading(2.0 * float(radii.max()), {"resolution": view.resolution})


def width_of(view: BarView, part: float) -> Reading:
    """Diameter at a part of the initial length above the impact face, between the layers beside it."""
    heights, radii = side_edges(view)
    level = end_edges(view)[0] + part * view.length
    if np.isnan(radii).any() or math.isnan(level):
        return LOST
    below = np.flatnonzero(heights < level)
    if not below.size or below[-1] + 1 == heights.size:
        return Reading(math.nan, flags=("too_short",))
    first = int(below[-1])  # from the rear down: a lip beside the foot may curl
    share = (level - heights[first]) / (heights[first + 1] - heights[first])
    radius = radii[first] + share * (radii[first + 1] - radii[first])
    return Reading(2.0 * float(radius), {"resolution": view.resolution})


def rear_of(view: BarView) -> Reading:
    """The mean place of the last layer of particles."""
    layer = view.place[:, 2]
    last = layer == layer.max()
    if last.sum() < np.unique(view.place[:, :2], axis=0).shape[0]:
        return LOST
    place = float(np.average(view.position[last, 2], weights=view.mass[last]))
    return Reading(place, {"resolution": view.resolution})


def middle_of(view: BarView, values: np.ndarray) -> Reading:
    """A value (n,) beside the axis, halfway along the bar as it was at the start.

    Where particles stand at nodes, theirs.
    """
    inner = np.flatnonzero((view.place[:, :2] == 0).all(axis=1))[::-1]
    layers, first = np.unique(view.place[inner, 2], return_index=True)
    if layers.size <= view.place[:, 2].max():
        return LOST
    column = inner[first]
    return Reading(float(np.interp(0.5 * view.length, view.height[column], values[column])))


@dataclass(frozen=True)
class Energies:
    """Where the initial energy of a bar has gone, as shares of it."""

    rigid: float  # motion of the bar as a whole, along its axis
    vibration: float  # motion of its parts against the whole
    strain: float  # elastic


def energies(view: BarView) -> Energies:
    """Kinetic energy split at the axial velocity of the centre of mass, and elastic energy."""
    mass = float(view.mass.sum())
    initial = 0.5 * mass * view.speed**2
    kinetic = 0.5 * float((view.mass * (view.velocity**2).sum(axis=1)).sum())
    rigid = 0.5 * float((view.mass * view.velocity[:, 2]).sum()) ** 2 / mass
    strain = float((view.mass * view.strain_energy).sum())
    return Energies(rigid / initial, (kinetic - rigid) / initial, strain / initial)
