"""The places of the runs of a sweep: points, which are values of its axes, and the refinements of each."""

import itertools
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from studies.quantities.parameters import Value
from studies.sweeps.axes import Axis
from studies.sweeps.reading import Combine

Place = tuple[tuple[int, ...], dict[str, Value]]  # index, and coordinates by the name of an axis, SI


@dataclass(frozen=True)
class Grid:
    """Axes, how their values are combined, and the axes over which each point is refined."""

    axes: tuple[Axis, ...]
    combine: Combine  # their product, pairs, or points sampled from their ranges
    refinements: tuple[Axis, ...]

    @property
    def shape(self) -> tuple[int, ...]:
        """The number of values on each axis (grid), or of points (else); then on each refinement."""
        lengths = tuple(len(axis.values) for axis in self.axes)
        lengths = lengths if self.combine == "grid" else lengths[:1]
        return lengths + tuple(len(axis.values) for axis in self.refinements)

    @property
    def size(self) -> int:
        """The number of places."""
        return math.prod(self.shape)

    @property
    def points(self) -> Iterator[Place]:
        """Index and coordinates of every point, before it is refined."""
        if self.combine == "grid":
            yield from product(self.axes)
            return
        names = [axis.name for axis in self.axes]
        for number, values in enumerate(zip(*(axis.values for axis in self.axes), strict=True)):
            yield (number,), dict(zip(names, values, strict=True))

    @property
    def of_cells(self) -> Iterator[dict[str, Value]]:
        """The points that may differ in their cells: all values of a searched axis are one."""
        others = tuple(axis for axis in self.axes if not axis.search)
        return (at for _, at in (product(others) if self.combine == "grid" else self.points))

    def key(self, at: Mapping[str, Value]) -> tuple[Value, ...]:
        """The point of coordinates: their values on the axes."""
        return tuple(at[axis.name] for axis in self.axes)

    def key_of_cells(self, at: Mapping[str, Value]) -> tuple[Value, ...]:
        """As ``key``, of the points that may differ in their cells."""
        return tuple(at[axis.name] for axis in self.axes if not axis.search)

    @property
    def middle(self) -> dict[str, Value]:
        """The values of the axes in the middle; of sampled axes, those of the point nearest to it."""
        if not any(axis.bounds for axis in self.axes):
            # Of a zip the values of one place belong together, too.
            return {axis.name: axis.values[len(axis.values) // 2] for axis in self.axes}

        def distance(at: Mapping[str, Value]) -> float:
            return sum(
                ((float(at[axis.name] or 0.0) - low) / (high - low) - 0.5) ** 2
                for axis in self.axes
                for low, high in [axis.bounds or (0.0, 1.0)]
            )

        return min((at for _, at in self.points), key=distance)


def product(axes: tuple[Axis, ...]) -> Iterator[Place]:
    """Index and coordinates of every cell of a grid, the last axis fastest."""
    names = [axis.name for axis in axes]
    for cell in itertools.product(*(enumerate(axis.values) for axis in axes)):
        yield tuple(place for place, _ in cell), dict(zip(names, (value for _, value in cell), strict=True))
