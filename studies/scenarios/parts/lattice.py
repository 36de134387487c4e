"""Grids of the models, lattices of particles, and a body of them."""

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    import numpy as np

    from solver.matter.laws import Matter
    from solver.problem import Body, Clamp, Face
    from solver.problem.geometry import Axisymmetric, Cartesian3D

Geometry: TypeAlias = "Axisymmetric | Cartesian3D"
Faces: TypeAlias = "tuple[tuple[Face, Face], ...]"

# Angle about the axis that a model covers, rad; 1 in axisymmetry, where all is per radian.
SECTORS = {"axisymmetric": 1.0, "quarter": 0.5 * math.pi, "half": math.pi}


def mesh(
    geometry: str,
    *,
    across: int,
    along: int,
    front: float,
    cell: float,
    side: tuple["Face", "Face"],
    flight: tuple["Face", "Face"],
) -> tuple[Geometry, Faces]:
    """The grid of a model and its faces, for cells of a size (m) from the axis and along the flight from ``front`` (m).

    A half model reaches as far to the other side of the axis, where the outer face of ``side`` ends it too.
    """
    from solver.problem import Face
    from solver.problem.geometry import Axisymmetric, Cartesian3D, grid

    if geometry == "axisymmetric":
        cells = (across, along, 0)
        flat = grid(Axisymmetric, lower=(0.0, front, 0.0), cells=cells, spacing=cell)
        return flat, (side, flight, (Face.FREE, Face.FREE))
    half = geometry == "half"
    box = grid(
        Cartesian3D,
        lower=(-across * cell if half else 0.0, 0.0, front),
        cells=(2 * across if half else across, across, along),
        spacing=cell,
    )
    return box, ((side[1], side[1]) if half else side, side, flight)


def line(begin: float, end: float, step: float) -> tuple["np.ndarray", float]:
    """Points in the middle of equal pieces that fill begin..end, and the piece nearest to ``step``."""
    import numpy as np

    pieces = max(1, round((end - begin) / step))
    piece = (end - begin) / pieces
    return begin + piece * (np.arange(pieces) + 0.5), piece


def points(*lines: "np.ndarray") -> "np.ndarray":
    """All points of the lattice that lines along the axes span, (n, axes); the last axis fastest."""
    import numpy as np

    return np.stack([axis.ravel() for axis in np.meshgrid(*lines, indexing="ij")], axis=-1)


@dataclass(frozen=True)
class BodyPoints:
    """Points about the line of flight that fill a part of a body, before they have mass."""

    position: "np.ndarray"  # (n, 3) m
    spacing: tuple[float, float, float]  # m
    axis: int  # of the flight

    @property
    def radius(self) -> "np.ndarray":
        """Distance of each point from the line of flight, m."""
        import numpy as np

        return self.position[:, 0] if self.axis == 1 else np.hypot(self.position[:, 0], self.position[:, 1])

    @property
    def along(self) -> "np.ndarray":
        """Place of each point along the flight, m."""
        return self.position[:, self.axis]

    def where(self, keep: "np.ndarray") -> "BodyPoints":
        """Some of the points."""
        return replace(self, position=self.position[keep])


def lattice(geometry: str, *, breadth: float, begin: float, end: float, step: float) -> BodyPoints:
    """Points, nearly a step (m) apart, of a prism about the line of flight, ``breadth`` (m) is half its width."""
    import numpy as np

    across, wide = line(0.0, breadth, step)
    along, high = line(begin, end, step)
    if geometry == "axisymmetric":
        return BodyPoints(points(across, along, np.zeros(1)), (wide, high, 0.0), 1)
    whole = np.concatenate([-across[::-1], across]) if geometry == "half" else across
    return BodyPoints(points(whole, across, along), (wide, wide, high), 2)


def flight_axis(geometry: str) -> int:
    """The axis of the line of flight."""
    return 1 if geometry == "axisymmetric" else 2


def along_flight(geometry: str, speed: float) -> "np.ndarray":
    """The velocity (3,) of a speed along the line of flight, m/s."""
    import numpy as np

    velocity = np.zeros(3)
    velocity[flight_axis(geometry)] = speed
    return velocity


def slab_clamp(geometry: str, thickness: float, cell: float) -> "Clamp":
    """The rim of a plate, and the cell (m) on either side that its particles reach; debris beyond it flies on."""
    import numpy as np

    from solver.problem import clamp

    # Nodes a cell away belong to it whatever the round-off.
    reach = (1.0 + 1e-6) * cell
    lower, upper = np.full(3, -np.inf), np.full(3, np.inf)
    axis = flight_axis(geometry)
    lower[axis], upper[axis] = -reach, thickness + reach
    return clamp(lower=lower, upper=upper)


def body(
    name: str,
    matter: "Matter",
    geometry: Geometry,
    points: BodyPoints,
    *,
    velocity: "np.ndarray",
    density: float,
    volume: float,
) -> "Body":
    """A body of lattice points whose masses add up to that of ``volume`` (m3, or m3 per radian)."""
    import numpy as np

    from solver.problem import Body
    from solver.problem.geometry import lattice_measure

    measure = np.ones(len(points.position)) * lattice_measure(geometry, points.position.T, points.spacing)
    return Body(
        name=name,
        matter=matter,
        position=points.position,
        velocity=velocity,
        mass=measure * (density * volume / measure.sum()),
        density=density,
        spacing=points.spacing,
    )
