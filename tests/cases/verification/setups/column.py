"""Plane problems as a column of cells, one cell wide, with symmetric sides: only the first axis sees anything.

Across the column stands one particle: nothing varies there, so that more would give the same sums. What comes out is
read off as a ``ColumnProfile``, and a front and the plateau behind it off that.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from solver.matter.laws import Matter
from solver.problem import Body, Face, Problem
from solver.problem.geometry import Cartesian3D, grid
from solver.state import Snapshot
from solver.units import JoulePerKilogram, KilogramPerCubicMetre, Metre, MetrePerSecond
from studies.quantities.numerical_defaults import Recipe
from studies.scenarios.parts.numerics import Numerics
from tests.cases.verification.setups.lattices import MIRRORS, lattice, middles

# Cells left out of a plateau at the interface or wall: start-up errors of the shock stay there.
INTERFACE_CELLS = 3.0
OUTER_SHARE = 0.2  # of a plateau, left out at its front: the front itself is a few cells wide


@dataclass(frozen=True)
class Stretch:
    """A part of a column that is one body."""

    name: str
    matter: Matter
    density: KilogramPerCubicMetre
    begin: Metre
    end: Metre
    velocity: MetrePerSecond | Callable[[np.ndarray], np.ndarray] = 0.0  # of the place
    energy: JoulePerKilogram = 0.0
    lighting: Callable[[np.ndarray], np.ndarray] | None = None  # of an explosive: s, of places (n, 3)


def with_numerics(problem: Problem, recipe: Recipe) -> Problem:
    """The problem with the numerics of a recipe."""
    return Numerics(**asdict(recipe)).applied_to(problem)


def column(
    stretches: Sequence[Stretch],
    recipe: Recipe,
    *,
    cells: int,
    spacing: float,
    end_time: float,
    lower: float = 0.0,
    ends: tuple[str, str] = ("FREE", "FREE"),
    boost: float = 0.0,
    **changes: Any,
) -> Problem:
    """The problem of a column from ``lower`` on, ``ends`` by the names of faces; ``boost`` (m/s) moves all of it."""
    geometry = grid(Cartesian3D, lower=(lower, 0.0, 0.0), cells=(cells, 1, 1), spacing=spacing)
    bodies = tuple(_body(stretch, spacing, recipe.particles_per_cell, boost) for stretch in stretches)
    faces = ((Face[ends[0]], Face[ends[1]]), MIRRORS, MIRRORS)
    problem = Problem(geometry=geometry, bodies=bodies, faces=faces, end_time=end_time)
    return replace(with_numerics(problem, recipe), **changes)


def _body(stretch: Stretch, spacing: float, along: int, boost: float) -> Body:
    count = round((stretch.end - stretch.begin) / spacing * along)
    step = (stretch.end - stretch.begin) / count
    side = np.array([0.5 * spacing])
    position = lattice(middles(count, step, stretch.begin), side, side)
    velocity = np.zeros_like(position)
    flow = stretch.velocity
    velocity[:, 0] = boost + (flow(position[:, 0]) if callable(flow) else flow)
    return Body(
        name=stretch.name,
        matter=stretch.matter,
        position=position,
        velocity=velocity,
        mass=np.full(count, stretch.density * (step * spacing**2)),
        density=stretch.density,
        spacing=(step, spacing, spacing),
        energy=stretch.energy,
        lighting=stretch.lighting(position) if stretch.lighting else None,
    )


@dataclass(frozen=True)
class ColumnProfile:
    """Particles of one body along a line or radius, by place; stress is that along the line, compression positive."""

    time: float
    place: np.ndarray  # m
    velocity: np.ndarray  # along the line, m/s
    stress: np.ndarray  # of equation of state and deviator, without artificial viscosity, Pa
    density: np.ndarray  # kg/m3
    energy: np.ndarray  # J/kg
    mass: np.ndarray  # kg
    number: np.ndarray

    @property
    def volume(self) -> np.ndarray:
        """m3."""
        return self.mass / self.density

    def part(self, keep: np.ndarray) -> "ColumnProfile":
        """Some of the particles."""
        fields = {name: value[keep] for name, value in vars(self).items() if name != "time"}
        return ColumnProfile(time=self.time, **fields)

    def mean(self, values: np.ndarray) -> float:
        """Mean weighted by volume."""
        return float((self.volume * values).sum() / self.volume.sum())


def profile(snapshot: Snapshot, body: int) -> ColumnProfile:
    """The living particles of a body along the first axis, as copies."""
    p = snapshot.particles
    stress = p.pressure - p.deviator[:, 0]
    return _profile(snapshot, snapshot.body == body, p.position[:, 0], p.velocity[:, 0], stress)


def radial_profile(snapshot: Snapshot) -> ColumnProfile:
    """All living particles of an axisymmetric problem by their distance from the origin; stress is the pressure."""
    p = snapshot.particles
    x, v, radius = p.position, p.velocity, np.hypot(p.position[:, 0], p.position[:, 1])
    outwards = (v[:, 0] * x[:, 0] + v[:, 1] * x[:, 1]) / radius
    return _profile(snapshot, np.full(radius.size, True), radius, outwards, p.pressure)


def _profile(
    snapshot: Snapshot, keep: np.ndarray, place: np.ndarray, velocity: np.ndarray, stress: np.ndarray
) -> ColumnProfile:
    p = snapshot.particles
    index = np.flatnonzero(keep & (p.alive == 1))
    index = index[np.argsort(place[index], kind="stable")]
    own = (each[index] for each in (place, velocity, stress, p.density, p.energy, p.mass, p.number))
    return ColumnProfile(snapshot.time, *own)


@dataclass(frozen=True)
class Plateau:
    """The matter between an interface or wall and a front; means are weighted by volume."""

    stress: float  # Pa
    scatter: float  # standard deviation of the stress over its mean
    density: float  # of the particles, kg/m3
    # From the places of the particles alone, in a column of one cell's width, kg/m3.
    spacing_density: float
    velocity: float  # m/s
    energy: float  # J/kg, weighted by mass


def front(line: ColumnProfile, spacing: float, level: float) -> float:
    """The outermost place, towards larger x, where the stress averaged over cells falls through a level.

    Between the middles of two cells it is interpolated; NaN where no cell reaches the level.
    """
    first = float(np.floor(line.place.min() / spacing))
    cell = np.floor(line.place / spacing - first).astype(int)
    volume = np.bincount(cell, line.volume)
    mean = np.bincount(cell, line.volume * line.stress) / np.where(volume > 0.0, volume, 1.0)
    above = np.flatnonzero((mean >= level) & (volume > 0.0))
    if not above.size or above[-1] + 1 >= mean.size:
        return float("nan")
    last = above[-1]
    share = (mean[last] - level) / (mean[last] - mean[last + 1])
    return float((first + last + 0.5 + share) * spacing)


def half_front(line: ColumnProfile, spacing: float, begin: float) -> tuple[float, Plateau]:
    """The front at half of the plateau's own stress, and the plateau from ``begin`` to it."""
    # A first guess of the level: half the median over the quarter of the particles next to the beginning.
    near = line.part(line.place > begin)
    level = 0.5 * float(np.median(near.stress[: max(1, near.place.size // 4)]))
    for _ in range(2):
        place = front(line, spacing, level)
        behind = plateau(line, spacing, begin, place)
        level = 0.5 * behind.stress
    return place, behind


def plateau(line: ColumnProfile, spacing: float, begin: float, end: float) -> Plateau:
    """The plateau between an interface and a front: three cells at the interface and the outer fifth left out."""
    low, high = begin + INTERFACE_CELLS * spacing, end - OUTER_SHARE * (end - begin)
    return between(line, spacing, low, high)


def between(line: ColumnProfile, spacing: float, low: float, high: float) -> Plateau:
    """The plateau between two places; NaN where fewer than two particles stand there."""
    inside = line.part((line.place > low) & (line.place < high))
    if inside.place.size < 2:
        nan = math.nan
        return Plateau(nan, nan, nan, nan, nan, nan)
    stress = inside.mean(inside.stress)
    # Mass up to each particle over its place, as a least-squares line: particles at the ends weigh no more than others.
    slope = np.polyfit(inside.place - low, np.cumsum(inside.mass) - 0.5 * inside.mass, 1)[0]
    return Plateau(
        stress=stress,
        scatter=float(np.sqrt(inside.mean((inside.stress - stress) ** 2))) / abs(stress),
        density=float(inside.mass.sum() / inside.volume.sum()),
        spacing_density=float(slope / spacing**2),
        velocity=float((inside.mass * inside.velocity).sum() / inside.mass.sum()),
        energy=float((inside.mass * inside.energy).sum() / inside.mass.sum()),
    )


def mirrored(line: ColumnProfile) -> ColumnProfile:
    """The line seen from the other side: x and v with the opposite sign."""
    turned = line.part(slice(None, None, -1))  # type: ignore[arg-type]
    return ColumnProfile(**{**vars(turned), "place": -turned.place, "velocity": -turned.velocity})
