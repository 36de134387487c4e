"""Solids before any method fills them, grids of the models, lattices of particles, and a body of them."""

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

    from solver.problem import Body, Face, Matter

# Angle about the axis that a model covers, rad; 1 in axisymmetry, where all is per radian.
SECTORS = {"axisymmetric": 1.0, "quarter": 0.5 * math.pi, "half": math.pi}


@dataclass(frozen=True)
class BodyShape:
    """A solid of revolution or a prism about the line of flight, before any method has filled it."""

    role: str  # the parameter that names its material
    begin: float  # along the flight, m
    end: float
    breadth: float  # largest distance from the line of flight, m
    is_round: bool  # a prism of square section where it is not
    nose: str  # of its end; "blunt" without
    nose_length: float  # m
    speed: float  # along the flight, m/s

    @property
    def volume(self) -> float:
        """Volume of the whole solid, m3."""
        area = math.pi * self.breadth**2 if self.is_round else 4.0 * self.breadth**2
        share = {"blunt": 1.0, "conical": 1.0 / 3.0, "hemispherical": 2.0 / 3.0}[self.nose]
        return area * (self.end - self.begin - (1.0 - share) * self.nose_length)

    def radius(self, place: Any) -> Any:
        """Radius of a round solid at places (n,) along the flight, m."""
        import numpy as np

        if self.nose == "blunt":
            return np.full(np.shape(place), self.breadth)
        part = np.clip((self.end - place) / self.nose_length, 0.0, 1.0)
        shape = part if self.nose == "conical" else np.sqrt(part * (2.0 - part))
        return self.breadth * shape


def mesh(
    geometry: str,
    *,
    across: int,
    along: int,
    front: float,
    cell: float,
    side: tuple["Face", "Face"],
    flight: tuple["Face", "Face"],
) -> tuple[Any, tuple[tuple["Face", "Face"], ...]]:
    """The grid of a model and its faces, for cells of a size (m) from the axis and along the flight from ``front`` (m).

    A half model reaches as far to the other side of the axis, where the outer face of ``side`` ends it too.
    """
    from solver.geometry import grid
    from solver.geometry.axisymmetric import Axisymmetric
    from solver.geometry.cartesian3d import Cartesian3D
    from solver.problem import Face

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


def body(
    name: str,
    matter: "Matter",
    geometry: Any,
    *,
    position: "np.ndarray",
    spacing: tuple[float, float, float],
    velocity: "np.ndarray",
    density: float,
    volume: float,
) -> "Body":
    """A body of lattice points (n, 3) whose masses add up to that of ``volume`` (m3, or m3 per radian)."""
    import numpy as np

    from solver.geometry import lattice_measure
    from solver.problem import Body

    measure = np.ones(position.shape[0]) * lattice_measure(geometry, position.T, spacing)
    return Body(
        name=name,
        matter=matter,
        position=position,
        velocity=velocity,
        mass=measure * (density * volume / measure.sum()),
        density=density,
        spacing=spacing,
    )
