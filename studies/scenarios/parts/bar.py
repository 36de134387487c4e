"""A bar that hits a wall: its model, lattice, faces, and the size of the work.

The wall is the face z = 0; the bar stands on it at z > 0 and flies towards -z. The lattice is stretched by a few per
cent where needed so that length and diameter are exact; the masses are scaled to the analytic mass, from which a
lattice cylinder differs by 1 %.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from solver.steppers import meshing
from solver.units import Described, Dimensionless, Metre, MetrePerSecond
from studies.quantities.findings import Finding
from studies.scenarios import Setting, SetUp, Size
from studies.scenarios.parts.lattice import SECTORS, along_flight, body, flight_axis, lattice, mesh, points
from studies.scenarios.parts.loading import Loading
from studies.scenarios.parts.method import ON_GRID, MethodChoice, is_coupled, is_meshed
from studies.scenarios.parts.numerics import Numerics
from studies.scenarios.parts.outline import Dimension, Outline, Shape

if TYPE_CHECKING:
    import numpy as np

    from solver.matter.laws import Matter
    from solver.problem import Body, Face
    from solver.state import Snapshot
    from studies.measurements.bar import BarView

BarSpeed = Annotated[
    MetrePerSecond, Described("impact speed, normal to the wall; 0 for a bar that loads alone set in motion", 0.0, 1e3)
]
BarLength = Annotated[Metre, Described("length of the bar", 1e-5, 1.0)]
BarDiameter = Annotated[Metre, Described("diameter of the bar, or side of a square one", 1e-5, 1.0)]
CellsAcross = Annotated[Dimensionless, Described("grid cells across the bar's diameter", 2.0, 512.0)]


@dataclass(frozen=True, kw_only=True)
class Wall:
    """Model of a bar and its wall."""

    geometry: Annotated[
        Literal["axisymmetric", "quarter"], Described("body of revolution, or a quarter of a bar in three dimensions")
    ] = "axisymmetric"
    section: Annotated[
        Literal["round", "square"],
        Described("section of the bar; a square one, whose side is bar_diameter, in three dimensions"),
    ] = "round"
    wall: Annotated[
        Literal["unilateral", "symmetric"],
        Described("frictionless wall that only pushes, or a wall that holds the normal velocity in both directions"),
    ] = "unilateral"


@dataclass(frozen=True, kw_only=True)
class Extent:
    """A bar in numbers, and the room and time that it gets."""

    length: float  # m
    diameter: float  # m
    speed: float  # m/s
    fastest: float  # of matter, with its loads, m/s
    cell: float  # m
    height: float  # of the grid, m
    radius: float  # of the grid, m
    end_time: float  # s


NO_OTHERS = (None, None, None)


@dataclass(frozen=True, kw_only=True)
class BarSetting(Setting):
    """A bar as its observer needs to know it."""

    length: float  # m
    diameter: float  # m
    speed: float  # m/s
    place: "np.ndarray"  # (n, 3) of each particle in the initial lattice: across, across, along
    # Length, mushroom diameter and width to be compared with, m.
    references: tuple[float | None, float | None, float | None] = NO_OTHERS


@dataclass(frozen=True, kw_only=True)
class Bar:
    """A bar at the moment when it touches the wall; what is asked of it needs filled records."""

    extent: Extent
    wall: Wall
    loading: Loading
    numerics: Numerics
    method: MethodChoice = ON_GRID

    def check(self, *, density: float, sound: float) -> Iterator[Finding]:
        """It is as long as a cell at least, square in three dimensions alone, and bears its loads.

        Its diameter has two cells by its own bounds.
        """
        extent = self.extent
        yield from self.loading.check(
            speed=extent.speed,
            density=density,
            sound=sound,
            time=extent.end_time,
            length=extent.length,
            cell=extent.cell,
        )
        if extent.length < extent.cell:
            cure = "raise the resolution (cells per diameter)"
            yield Finding("bar_length", f"{extent.length:g} m", f"at least a cell, {extent.cell:g} m", cure)
        if self.wall.section == "square" and self.wall.geometry == "axisymmetric":
            yield Finding("section", "square", "round in a body of revolution", "set geometry to quarter")

    def size(self, sound: float) -> Size:
        """Particles from the volume, and steps from the stable step of the undisturbed state."""
        extent = self.extent
        if self.wall.geometry == "axisymmetric":
            particles = 0.5 * extent.diameter * extent.length / self.step**2
        else:
            particles = self.section * extent.length / self.step**3
        dt = self.numerics.mean_step(extent.cell, sound=sound, speed=extent.fastest)
        return Size(particles=round(particles), steps=math.ceil(extent.end_time / dt))

    def build(
        self, matter: "Matter", density: float, references: tuple[float | None, float | None, float | None] = NO_OTHERS
    ) -> BarSetting:
        """The problem, for a density (kg/m3), and the sizes to compare with (m)."""
        from solver.problem import Problem

        extent, axis = self.extent, flight_axis(self.wall.geometry)
        geometry, faces = self._grid()
        bodies, place = (self._meshed if is_meshed(self.method) else self._filled)(matter, density, geometry)
        return BarSetting(
            problem=Problem(
                geometry=geometry,
                bodies=bodies,
                faces=faces,
                end_time=extent.end_time,
                **self.loading.arguments(axis=axis, end_time=extent.end_time),
                **self.numerics.arguments(self.method),
            ),
            sector=SECTORS[self.wall.geometry],
            length=extent.length,
            diameter=extent.diameter,
            speed=extent.speed,
            place=place,
            references=references,
        )

    @property
    def step(self) -> float:
        """Distance of two particles, m."""
        return self.extent.cell / self.numerics.choices.particles_per_cell

    @property
    def section(self) -> float:
        """Area of the section that the model has, m2 (m2 per radian)."""
        radius = 0.5 * self.extent.diameter
        if self.wall.geometry == "axisymmetric":
            return 0.5 * radius**2
        return (1.0 if self.wall.section == "square" else 0.25 * math.pi) * radius**2

    def _grid(self) -> tuple[Any, tuple[tuple["Face", "Face"], ...]]:
        from solver.problem import Face

        extent = self.extent
        return mesh(
            self.wall.geometry,
            across=math.ceil(extent.radius / extent.cell - 1e-9),
            along=math.ceil(extent.height / extent.cell - 1e-9),
            front=0.0,
            cell=extent.cell,
            side=(Face.SYMMETRIC, Face.FREE),
            flight=(Face.WALL if self.wall.wall == "unilateral" else Face.SYMMETRIC, Face.FREE),
        )

    def _filled(self, matter: "Matter", density: float, geometry: Any) -> tuple[tuple["Body", ...], "np.ndarray"]:
        """The bar, and the place of each of its particles in the lattice."""
        import numpy as np

        extent, flat = self.extent, self.wall.geometry == "axisymmetric"
        radius = 0.5 * extent.diameter
        where = lattice(self.wall.geometry, breadth=radius, begin=0.0, end=extent.length, step=self.step)
        across, layers = round(radius / where.spacing[0]), round(extent.length / where.spacing[where.axis])
        place = points(np.arange(across), np.arange(1 if flat else across), np.arange(layers))
        if self.wall.section == "round":
            inside = where.radius < radius
            where, place = where.where(inside), place[inside]
        made = body(
            "bar",
            matter,
            geometry,
            where,
            velocity=along_flight(self.wall.geometry, -extent.speed),
            density=density,
            volume=self.section * extent.length,
        )
        return (made,), place

    def _meshed(self, matter: "Matter", density: float, geometry: Any) -> tuple[tuple["Body", ...], "np.ndarray"]:
        """A square bar of elements, or of these and of particles below them, and the place of each node or particle."""
        import numpy as np

        from solver.problem import Body

        extent, make = self.extent, meshing(self.method.method)
        pieces, layers = (max(1, round(whole / self.step)) for whole in (0.5 * extent.diameter, extent.length))
        across = np.linspace(0.0, 0.5 * extent.diameter, pieces + 1)
        along = np.linspace(0.0, extent.length, layers + 1)
        middle = layers // 2 if is_coupled(self.method) else 0
        parts = [("bar-elements" if middle else "bar", middle, layers)]
        parts += [("bar", 0, middle)] if middle else []
        bodies, places = [], []
        for number, (name, begin, end) in enumerate(parts):
            position, elements = make.box(across, across, along[begin : end + 1])
            bodies.append(
                Body(
                    name=name,
                    matter=matter,
                    position=position,
                    velocity=np.array([0.0, 0.0, -extent.speed]),
                    mass=make.node_masses(elements, position, density),
                    density=density,
                    spacing=(across[1], across[1], along[1]),
                    mesh=None if number else elements,
                )
            )
            corners = np.arange(pieces + 1)
            places.append(points(corners, corners, np.arange(begin, end + 1)))
        return tuple(bodies), np.concatenate(places)


class BarSetUp(SetUp):
    """The parameters of a bar: which, its scenario says."""

    cells_per_diameter: float

    @staticmethod
    def view(setting: BarSetting, snapshot: "Snapshot") -> "BarView":
        from studies.measurements.bar import view

        return view(setting, snapshot)

    def cells(self) -> dict[str, float]:
        return {"cells_per_diameter": self.cells_per_diameter}

    @staticmethod
    def outline(values: Mapping[str, Any]) -> Outline | None:
        """The bar as it touches the wall."""
        high, wide = values.get("bar_length"), values.get("bar_diameter")
        if not high or not wide:
            return None
        half = 0.5 * wide
        bar = Shape("bar", -half, half, 0.0, high, heading=(0.0, -1.0))
        wall = Shape("wall", -3.0 * half, 3.0 * half, -0.3 * half, 0.0)
        dimensions = (
            Dimension("bar_diameter", (-half, high), (half, high)),
            Dimension("bar_length", (half, 0.0), (half, high)),
        )
        return Outline((bar, wall), dimensions)
