"""A bar that hits a wall: its model, lattice, faces, and the size of the work.

The wall is the face z = 0; the bar stands on it at z > 0 and flies towards -z. The lattice is stretched by a few per
cent where needed so that length and diameter are exact; the masses are scaled to the analytic mass, from which a
lattice cylinder differs by 1 %.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import KW_ONLY, dataclass
from typing import TYPE_CHECKING, Annotated, Literal

from solver.steppers import meshing
from solver.units import Described, Dimensionless, Metre, MetrePerSecond
from studies.bars.loading import Loading
from studies.bars.setting import BarSetting, References
from studies.quantities.findings import Finding
from studies.quantities.parameters import Plain
from studies.quantities.units import readable, round_quantity
from studies.scenarios import SetUp, Size
from studies.scenarios.parts.lattice import SECTORS, along_flight, body, lattice, mesh, points
from studies.scenarios.parts.method import ON_GRID
from studies.scenarios.parts.numerics import Numerics
from studies.scenarios.parts.outline import Dimension, Outline, Shape, number

if TYPE_CHECKING:
    import numpy as np

    from solver.matter.laws import Matter
    from solver.problem import Body
    from solver.state import Snapshot
    from studies.bars.measured import BarView
    from studies.scenarios.parts.lattice import Geometry

FASTEST = 0.3  # of the wave speed: the strain at which matter moves so fast is no small one
# Nodes within two cells of the end carry the pressure (``solver.grid.loads.REACH``), and those of the other end lie
# within one and a half of it: they stay apart until the bar is half as long.
LEAST_CELLS = 8.0
FINER = "raise the resolution (cells per diameter)"

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


class BarSetUp(SetUp[BarSetting, "BarView"]):
    """Parameters of a bar at a wall; a scenario declares them."""

    wall: Wall
    speed: float
    bar_length: float
    bar_diameter: float
    cells_per_diameter: float
    end_time: float | None
    loading: Loading
    numerics: Numerics
    method = ON_GRID

    @property
    def cell(self) -> float:
        """Size of a cell, m."""
        return self.bar_diameter / self.cells_per_diameter

    @property
    def end(self) -> float:
        """End of the run, s."""
        assert self.end_time is not None
        return self.end_time

    def fastest(self, impedance: float) -> float:
        """Speed of the fastest matter with its loads, m/s; ``impedance`` is rho c, Pa s/m."""
        return self.speed + self.loading.added_speed(impedance=impedance, time=self.end)

    @staticmethod
    def view(setting: BarSetting, snapshot: "Snapshot") -> "BarView":
        from studies.bars.measured import view

        return view(setting, snapshot)

    def cells(self) -> dict[str, float]:
        return {"cells_per_diameter": self.cells_per_diameter}

    @staticmethod
    def outline(values: Mapping[str, Plain]) -> Outline | None:
        """The bar as it touches the wall."""
        high, half = number(values, "bar_length"), 0.5 * number(values, "bar_diameter")
        if not high or not half:
            return None
        bar = Shape("bar", -half, half, 0.0, high, heading=(0.0, -1.0))
        wall = Shape("wall", -3.0 * half, 3.0 * half, -0.3 * half, 0.0)
        dimensions = (
            Dimension("bar_diameter", (-half, high), (half, high)),
            Dimension("bar_length", (half, 0.0), (half, high)),
        )
        return Outline((bar, wall), dimensions)


@dataclass(frozen=True)
class Bar:
    """A bar at the moment when it touches the wall, by its filled parameters."""

    parameters: BarSetUp
    _: KW_ONLY
    density: float  # kg/m3
    sound: float  # speed of elastic waves along it, m/s
    height: float  # of the grid, m
    radius: float  # of the grid, m

    def check(self) -> Iterator[Finding]:
        """It is as long as a cell at least, square in three dimensions alone, and bears its loads.

        Its diameter has two cells by its own bounds.
        """
        own = self.parameters
        yield from own.loading.check_pulse(own.end)
        yield from self._check_loads()
        if own.bar_length < own.cell:
            yield Finding("bar_length", f"{own.bar_length:g} m", f"at least a cell, {own.cell:g} m", FINER)
        if own.wall.section == "square" and own.wall.geometry == "axisymmetric":
            yield Finding("section", "square", "round in a body of revolution", "set geometry to quarter")

    def _check_loads(self) -> Iterator[Finding]:
        """A bar that rests has loads, which keep it slow enough for small strains."""
        own, loading = self.parameters, self.parameters.loading
        why = f"at which matter moves at {FASTEST:g} of its wave speed"
        fastest, gravity, least = FASTEST * self.sound, abs(loading.gravity), LEAST_CELLS * own.cell
        largest = self.density * self.sound * fastest
        if loading.pressure is not None and abs(loading.pressure) > largest:
            limit = f"at most {readable(round_quantity(largest), 'Pa')}, {why}"
            yield Finding("pressure", readable(loading.pressure, "Pa"), limit, "choose a lower pressure")
        if gravity * own.end > fastest:
            limit = f"at most {round_quantity(fastest / own.end):g} m/s2, {why} at the end"
            yield Finding("gravity", f"{loading.gravity:g} m/s2", limit, "choose less gravity, or an earlier end_time")
        if own.speed == 0.0 and not loading.pressure and not gravity:
            limit = "more than 0 m/s for a bar without loads"
            yield Finding("speed", "0 m/s", limit, "give speed, pressure or gravity")
        if loading.pressure and own.bar_length < least:
            limit = f"at least {LEAST_CELLS:g} cells under a pressure, {readable(least, 'm')}"
            yield Finding("bar_length", readable(own.bar_length, "m"), limit, FINER)

    def size(self, sound: float) -> Size:
        """Particles from the volume, and steps from the stable step at a speed of waves in space (m/s)."""
        own = self.parameters
        if own.wall.geometry == "axisymmetric":
            particles = 0.5 * own.bar_diameter * own.bar_length / self.step**2
        else:
            particles = self.section * own.bar_length / self.step**3
        dt = own.numerics.mean_step(own.cell, sound=sound, speed=own.fastest(self.density * self.sound))
        return Size(particles=round(particles), steps=math.ceil(own.end / dt))

    def build(self, matter: "Matter", references: References = (None, None, None)) -> BarSetting:
        """The problem of a bar of some matter, with the sizes to compare with (m)."""
        from solver.problem import Face, Problem

        own, geometry = self.parameters, self.parameters.wall.geometry
        grid, faces = mesh(
            geometry,
            across=math.ceil(self.radius / own.cell - 1e-9),
            along=math.ceil(self.height / own.cell - 1e-9),
            front=0.0,
            cell=own.cell,
            side=(Face.SYMMETRIC, Face.FREE),
            flight=(Face.WALL if own.wall.wall == "unilateral" else Face.SYMMETRIC, Face.FREE),
        )
        bodies, place = self._meshed(matter) if own.method.is_meshed else self._filled(matter, grid)
        problem = Problem(geometry=grid, bodies=bodies, faces=faces, end_time=own.end)
        return BarSetting(
            problem=own.numerics.applied_to(own.loading.applied_to(problem), own.method),
            sector=SECTORS[geometry],
            length=own.bar_length,
            speed=own.speed,
            place=place,
            references=references,
        )

    @property
    def step(self) -> float:
        """Distance of two particles, m."""
        return self.parameters.cell / self.parameters.numerics.choices.particles_per_cell

    @property
    def section(self) -> float:
        """Area of the section that the model has, m2 (m2 per radian)."""
        radius, wall = 0.5 * self.parameters.bar_diameter, self.parameters.wall
        if wall.geometry == "axisymmetric":
            return 0.5 * radius**2
        return (1.0 if wall.section == "square" else 0.25 * math.pi) * radius**2

    def _filled(self, matter: "Matter", grid: "Geometry") -> tuple[tuple["Body", ...], "np.ndarray"]:
        """The bar, and the place of each of its particles in the lattice."""
        import numpy as np

        own, geometry = self.parameters, self.parameters.wall.geometry
        radius = 0.5 * own.bar_diameter
        where = lattice(geometry, breadth=radius, begin=0.0, end=own.bar_length, step=self.step)
        across, layers = round(radius / where.spacing[0]), round(own.bar_length / where.spacing[where.axis])
        aside = 1 if geometry == "axisymmetric" else across
        place = points(np.arange(across), np.arange(aside), np.arange(layers))
        if own.wall.section == "round":
            inside = where.radius < radius
            where, place = where.where(inside), place[inside]
        made = body(
            "bar",
            matter,
            grid,
            where,
            velocity=along_flight(geometry, -own.speed),
            density=self.density,
            volume=self.section * own.bar_length,
        )
        return (made,), place

    def _meshed(self, matter: "Matter") -> tuple[tuple["Body", ...], "np.ndarray"]:
        """A square bar of elements, or of these and of particles below them, and the place of each node or particle."""
        import numpy as np

        from solver.problem import Body

        own, make = self.parameters, meshing(self.parameters.method.method)
        pieces, layers = (max(1, round(whole / self.step)) for whole in (0.5 * own.bar_diameter, own.bar_length))
        across = np.linspace(0.0, 0.5 * own.bar_diameter, pieces + 1)
        along = np.linspace(0.0, own.bar_length, layers + 1)
        middle = layers // 2 if own.method.is_coupled else 0
        parts = [("bar-elements" if middle else "bar", middle, layers)]
        parts += [("bar", 0, middle)] if middle else []
        bodies, places, corners = [], [], np.arange(pieces + 1)
        for index, (name, begin, end) in enumerate(parts):
            position, elements = make.lattice(across, across, along[begin : end + 1])
            bodies.append(
                Body(
                    name=name,
                    matter=matter,
                    position=position,
                    velocity=np.array([0.0, 0.0, -own.speed]),
                    mass=make.node_masses(elements, position, self.density),
                    density=self.density,
                    spacing=(across[1], across[1], along[1]),
                    mesh=None if index else elements,
                )
            )
            places.append(points(corners, corners, np.arange(begin, end + 1)))
        return tuple(bodies), np.concatenate(places)
