"""The set-up before a run, to scale: outlines of its bodies, and the lengths that a report writes beside them."""

from collections.abc import Mapping
from dataclasses import dataclass

from studies.quantities.parameters import Plain


@dataclass(frozen=True)
class Shape:
    """The outline of a body before a run: a box or a disc in the plane through the axis, m."""

    body: str  # the parameter that names its material; "wall" of what has none
    left: float
    right: float
    top: float  # along the line of flight, towards which the projectile flies
    bottom: float
    is_disc: bool = False
    heading: tuple[float, float] | None = None  # direction of its flight, across and along


@dataclass(frozen=True)
class Dimension:
    """A length of the set-up with its two ends (across, along), m."""

    parameter: str
    begin: tuple[float, float]
    end: tuple[float, float]


@dataclass(frozen=True)
class Outline:
    """The set-up before a run, to scale, in the plane through the axis."""

    shapes: tuple[Shape, ...]
    dimensions: tuple[Dimension, ...]

    @property
    def upward(self) -> float:
        """The factor that lets the coordinate along the line of flight point down: -1 where a body flies against it."""
        return -1.0 if any(shape.heading and shape.heading[1] < 0.0 for shape in self.shapes) else 1.0


def number(values: Mapping[str, Plain], name: str) -> float:
    """A number among values by name; 0 where it is missing or no number."""
    value = values.get(name)
    return float(value) if isinstance(value, int | float) else 0.0
