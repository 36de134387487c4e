"""A Whipple shield: a projectile breaks up on a bumper, and its debris hits a wall behind an empty space.

Two stages, each on a grid of its own, because the space between is a hundred times the thickness of the bumper. The
first is the impact on the bumper. What comes off leaves its grid as soon as nothing of the bumper can meet it and its
own pressure drives it apart no more, and flies straight. The second has the wall alone, at the face of whose grid each
particle joins with all of its state at the time of its arrival. Debris whose path misses that grid stays in the books.

A body of revolution smears debris off the axis into rings, which load the wall evenly: what single fragments do to it
shows in three dimensions alone.

On the clock of a run the second stage goes on where the first one ends: the number ``clock_ahead`` (s) says by how much
that is later than the moment, after the first touch, at which debris comes to the grid of the wall.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal, Self

from solver.units import Described, Dimensionless, Metre, Second
from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import DebrisName
from studies.quantities.parameters import MaterialName
from studies.quantities.units import readable, round_quantity
from studies.scenarios import Materials, ObservationRate, Scenario, Setting, Size
from studies.scenarios.parts.impact import MOMENTS, REACH, Impact, ImpactSetting, ImpactSetUp, outline
from studies.scenarios.parts.lattice import slab_clamp
from studies.scenarios.parts.matter import Fracture
from studies.scenarios.parts.numerics import Numerics
from studies.scenarios.parts.outline import Dimension, Outline, Shape
from studies.scenarios.parts.shot import RADIUS, Projectile, Settling, ShotOptions
from studies.scenarios.thin_plate import CAP_PER_DIAMETER

if TYPE_CHECKING:
    from solver.grid.flight import Flight
    from solver.problem import Problem
    from solver.simulation import Outcome
    from studies.films.section import SectionOptions
    from studies.materials import Material

# Of the impact speed: what its own pressure may still add to the speed of a piece that leaves the bumper's grid. It
# turns a path by 0.02 rad, which is 2 mm in a flight of 100 mm: the thickness of a wall.
SPREAD = 0.02
# Of the impact speed: matter that is slower has not come to the wall when its stage ends at the latest. It has 4 % of
# the kinetic energy of what comes first.
SLOWEST = 0.2
# Of the space between bumper and wall: radius of the wall that is modelled. Clouds open by 30 degrees to either side
# and less (their largest radius is about half of their length); what flies past is counted.
WALL_RADIUS = math.tan(math.radians(30.0))
# Of the cells across the projectile: through the wall. At 32 across, 8: a hole is within 1 % from there on.
WALL_CELLS = 0.25
# Cells of the bumper in one of the wall, at most: coarser ones would not resolve a solid piece of the projectile.
WIDEST_CELL = 2.0
# Steps of the wall's stage over those of its undisturbed state: the viscosity of what flies into it shortens them, by
# six (5 mm of aluminium at 6.5 km/s, 32 cells, 2026-11-25), and the stage settles in half of its time.
WALL_STEPS = 3.0
LEAST_ROOM = 1.0  # behind the bumper, projectile diameters: what comes off needs a place in which it expands
LEAST_CELLS: Mapping[str, float] = {"cells_per_diameter": 16.0, "cells_per_thickness": 6.0, "cells_per_wall": 8.0}
FEWEST_CELLS: Mapping[str, float] = {"cells_per_thickness": 2.0, "cells_per_wall": 2.0}


@dataclass(frozen=True)
class ShieldSetting(ImpactSetting):
    """A stage of a shield: the impact on the bumper, or that of the debris on the wall."""

    melting: tuple[Any, ...] = ()  # no melted share is measured
    breakup: tuple[Any, ...] = ()  # and no size of fragments
    before: "BumperStage | None" = None  # of the stage of the wall: that of the bumper


@dataclass(frozen=True)
class BumperStage:
    """The end of the bumper's stage, and the flight from there."""

    bumper: Any  # studies.measurements.impact.view.ImpactView
    cloud: Any  # studies.measurements.cloud.CloudView
    coming: float  # mass that flies to the wall's grid, kg (per radian in axisymmetry)
    missed: float  # part of all mass that flies past the wall's grid
    clock_ahead: float  # s


@dataclass(frozen=True, kw_only=True)
class Sheets(Projectile):
    """A projectile, and the materials of a shield."""

    bumper: Annotated[MaterialName, Described("material of the bumper")]
    wall: Annotated[MaterialName, Described("material of the rear wall")]


@dataclass(frozen=True, kw_only=True)
class ShotAtShield(ShotOptions, Sheets):
    """A shot at a shield."""

    edges: Annotated[
        Literal["fixed", "free"],
        Described("what holds the rims of bumper and wall; debris that flies past them leaves the grid"),
    ] = "fixed"
    end_time: Annotated[
        Second | None,
        Described(
            "latest end of the bumper's stage; by default 7.5 ms per metre of diameter (60 us at 8 mm)", 1e-9, 1.0
        ),
    ] = None
    debris: Annotated[
        DebrisName | None, Described("debris flies straight from bumper to wall: retire is the one choice")
    ] = "retire"
    uprange: Annotated[
        Dimensionless | None,
        Described(
            "grid in front of bumper and wall, in projectile diameters; by default that of the recipe", 0.5, 50.0
        ),
    ] = None
    downrange: Annotated[
        Dimensionless | None,
        Described(
            "grid behind bumper and wall, in projectile diameters; by default that of the recipe, and behind the "
            "bumper no more than the grid of the wall leaves",
            0.5,
            50.0,
        ),
    ] = None


@dataclass(frozen=True, kw_only=True)
class Walls:
    """The sheets of a shield and the space between them."""

    bumper_thickness: Annotated[Metre, Described("thickness of the bumper", 1e-6, 1.0)]
    stand_off: Annotated[Metre, Described("space between the back of the bumper and the front of the wall", 1e-4, 10.0)]
    wall_thickness: Annotated[Metre, Described("thickness of the rear wall", 1e-6, 1.0)]
    bumper_radius: Annotated[
        Metre | None,
        Described("radius of a round bumper, half the width of a square one; by default 3.5 diameters", 1e-5, 10.0),
    ] = None
    wall_radius: Annotated[
        Metre | None,
        Described(
            "radius of a round wall, half the width of a square one; by default that of a cone of 30 degrees from the "
            "bumper, and 3.5 diameters at least",
            1e-5,
            10.0,
        ),
    ] = None
    cells_per_wall: Annotated[
        Dimensionless | None,
        Described(
            "grid cells through the wall; by default a quarter of those across the projectile, and so many that none "
            "is wider than two of the bumper's grid",
            0.5,
            512.0,
        ),
    ] = None
    wall_time: Annotated[
        Second | None,
        Described(
            "latest end of the wall's stage after its first debris; by default 7.5 ms per metre of diameter, and what "
            "a fifth of the impact speed takes from bumper to wall",
            1e-9,
            1.0,
        ),
    ] = None

    def filled(self, shot: ShotAtShield) -> Self:
        """With all that follows from the shot."""
        diameter = shot.projectile_diameter
        cells = max(WALL_CELLS * shot.cells_per_diameter, self.wall_thickness / (WIDEST_CELL * shot.cell))
        late = CAP_PER_DIAMETER * diameter + self.stand_off / (SLOWEST * shot.speed)
        wall = max(RADIUS * diameter, WALL_RADIUS * self.stand_off)
        return replace(
            self,
            bumper_radius=round_quantity(self.bumper_radius or RADIUS * diameter),
            wall_radius=round_quantity(self.wall_radius or wall),
            cells_per_wall=round_quantity(self.cells_per_wall or cells),
            wall_time=round_quantity(self.wall_time or late),
        )

    def check(self, shot: ShotAtShield) -> list[Finding]:
        """Sheets are wider than the projectile and no thinner than half a cell."""
        findings, diameter = [], shot.projectile_diameter
        for name, radius in (("bumper_radius", self.bumper_radius), ("wall_radius", self.wall_radius)):
            assert radius is not None
            if radius < diameter:
                limit = f"at least the projectile's diameter, {readable(diameter, 'm')}"
                findings.append(Finding(name, readable(radius, "m"), limit, f"leave {name} out"))
        if self.bumper_thickness < 0.5 * shot.cell:
            limit = f"at least half a cell, {readable(0.5 * shot.cell, 'm')}"
            cure = "raise the resolution (cells per diameter)"
            findings.append(Finding("bumper_thickness", readable(self.bumper_thickness, "m"), limit, cure))
        return findings


@dataclass(frozen=True, kw_only=True)
class WhippleShield(ImpactSetUp):
    """Parameters of a shield."""

    shot: ShotAtShield
    fracture: Fracture
    numerics: Numerics
    settling: Settling
    walls: Walls

    @property
    def impact(self) -> Impact:
        """The projectile in front of the bumper, on a grid that ends before that of the wall."""
        assert self.walls.bumper_radius is not None
        assert self.shot.downrange is not None
        shot = replace(self.shot, downrange=min(self.shot.downrange, self._between))
        return Impact(
            shot,
            self.fracture,
            self.numerics,
            thickness=self.walls.bumper_thickness,
            radius=self.walls.bumper_radius,
            target="bumper",
            expansion=0.5 * (SPREAD * shot.speed) ** 2,
        )

    @property
    def rear(self) -> Impact:
        """The wall on a grid of its own; its projectile is not there."""
        walls = self.walls
        assert walls.cells_per_wall is not None
        assert walls.wall_radius is not None
        cells = walls.cells_per_wall * self.shot.projectile_diameter / walls.wall_thickness
        shot = replace(self.shot, cells_per_diameter=cells, end_time=walls.wall_time)
        thickness, radius = walls.wall_thickness, walls.wall_radius
        return replace(self.impact, shot=shot, thickness=thickness, radius=radius, target="wall")

    @property
    def stages(self) -> int:
        return 2

    @property
    def _before_wall(self) -> float:
        """Grid in front of the wall at most, in projectile diameters: that of ``Impact.grid``."""
        shot, walls = self.shot, self.walls
        assert shot.uprange is not None
        assert walls.cells_per_wall is not None
        cell = walls.wall_thickness / walls.cells_per_wall
        return (
            max(shot.uprange * shot.projectile_diameter, shot.length + 2.0 * cell) + cell
        ) / shot.projectile_diameter

    @property
    def _between(self) -> float:
        """Room between the bumper and the grid of the wall, in projectile diameters."""
        return self.walls.stand_off / self.shot.projectile_diameter - self._before_wall

    def filled(self) -> Self:
        diameter, numerics = self.shot.projectile_diameter, self.numerics
        return replace(
            self,
            shot=self.shot.filled(numerics, end_time=CAP_PER_DIAMETER * diameter),
            numerics=numerics.filled(few=self.shot.geometry != "axisymmetric"),
            settling=self.settling.filled(diameter),
            walls=self.walls.filled(self.shot),
        )

    def check(self, materials: Materials) -> list[Finding]:
        findings = [*self._refused()]
        if findings:
            return findings
        return [
            *self.impact.check(materials),
            *self.settling.check(self.shot.projectile_diameter),
            *self.walls.check(self.shot),
        ]

    def _refused(self) -> list[Finding]:
        """What stages cannot compute, by name."""
        findings, least = [], LEAST_ROOM + self._before_wall
        if self.shot.geometry == "half":
            cure = "set geometry to axisymmetric or quarter"
            findings.append(Finding("geometry", "half", "a shield that is hit at right angles", cure))
        if self.shot.debris != "retire":
            limit = "retire: followed debris does not come to the wall"
            findings.append(Finding("debris", str(self.shot.debris), limit, "leave debris out"))
        if self._between < LEAST_ROOM - 1e-9:
            away = readable(round_quantity(least * self.shot.projectile_diameter), "m")
            limit = f"at least the grid in front of the wall and {LEAST_ROOM:g} projectile diameter, {away}"
            cure = "reduce uprange, or compute bumper and wall on one grid as a deck"
            findings.append(Finding("stand_off", readable(self.walls.stand_off, "m"), limit, cure))
        return findings

    def build(self, materials: Materials) -> Setting:
        setting = self.impact.build(materials)
        return ShieldSetting(**{**vars(setting), "settles": ("bumper_hole_diameter",)})

    def next_stage(self, setting: Any, outcome: "Outcome", materials: Materials) -> Setting | None:
        """The wall, to which the debris of the bumper flies."""
        if setting.before is not None:
            return None
        from solver.grid.flight import fly
        from solver.state import MASS
        from studies.measurements.shield import view

        walls, rear, snapshot = self.walls, self.rear, outcome.snapshot
        geometry, _ = rear.grid()
        shift, before = walls.bumper_thickness + walls.stand_off, setting.problem
        flight = fly(before, snapshot, outcome.books, geometry=geometry, shift=shift, bodies=len(before.bodies) + 1)
        seen, whole = view(setting, snapshot), sum(float(each.mass.sum()) for each in before.bodies)
        return replace(
            setting,
            problem=self._wall_problem(materials["wall"], before, flight, begin=snapshot.time),
            target="wall",
            thickness=rear.thickness,
            radius=rear.radius,
            settles=("wall_perforated", "wall_bulge"),
            before=BumperStage(
                bumper=seen.bumper,
                cloud=seen.cloud,
                coming=float(flight.arrivals.table[MASS].sum()),
                missed=flight.missed / whole,
                clock_ahead=flight.ahead,
            ),
        )

    def _wall_problem(self, wall: "Material", before: "Problem", flight: "Flight", *, begin: float) -> "Problem":
        """The wall and, still without particles, the bodies of the stage ``before``; its clock begins at a time (s)."""
        import numpy as np

        from solver.problem import Problem, Retirement

        rear, cell = self.rear, self.rear.shot.cell
        geometry, faces = rear.grid()
        nothing, still = np.zeros(0), np.zeros(3)
        gone = [replace(each, position=np.zeros((0, 3)), velocity=still, mass=nothing) for each in before.bodies]
        return Problem(
            geometry=geometry,
            bodies=(*gone, rear.body("wall", wall, geometry, *rear.points(), still)),
            faces=faces,
            clamp=slab_clamp(self.shot.geometry, rear.thickness, cell),
            start_time=begin,
            end_time=begin + rear.end_time,
            retirement=Retirement(body=len(gone), after=begin + rear.clear, expansion=rear.expansion),
            arrivals=flight.arrivals,
            books=flight.books,
            **self.numerics.arguments(),
        )

    def rate(self, setting: Any) -> ObservationRate:
        return self.settling.rate

    def size(self, materials: Materials) -> Size:
        """The most particles of a stage, and as many steps as give the work of both."""
        first, second = self.impact.size(), self.rear.size()
        most = max(first.particles, second.particles)
        work = first.particles * first.steps + WALL_STEPS * second.particles * second.steps
        return Size(particles=most, steps=round(work / most))

    def cells(self) -> dict[str, float]:
        assert self.walls.cells_per_wall is not None
        return {**self.impact.cells(), "cells_per_wall": self.walls.cells_per_wall}

    @staticmethod
    def view(setting: Any, snapshot: Any) -> Any:
        from studies.measurements.shield import view

        return view(setting, snapshot)

    @staticmethod
    def numbers(view: Any) -> dict[str, float]:
        """The part of all mass that flew past the wall's grid, and by how much the clock of its stage is ahead."""
        return {"missed_mass_fraction": view.missed, "clock_ahead": view.clock_ahead}

    def sections(self, setting: Any) -> "SectionOptions":
        from studies.films.section import SectionOptions

        shot = self.shot
        if setting.before is not None:
            return SectionOptions()
        moments = tuple(moment * max(shot.projectile_diameter, shot.length) / shot.speed for moment in MOMENTS)
        return SectionOptions(moments=moments, reach=REACH * shot.projectile_diameter)

    @staticmethod
    def outline(values: Mapping[str, Any]) -> Outline | None:
        before = outline(values, thickness="bumper_thickness", radius="bumper_radius", target="bumper")
        space, depth, rim = (values.get(name) for name in ("stand_off", "wall_thickness", "wall_radius"))
        if before is None or not space or not depth or not rim:
            return None
        back = values["bumper_thickness"]
        front = back + space
        return Outline(
            (*before.shapes, Shape("wall", -rim, rim, front, front + depth)),
            (
                *before.dimensions,
                Dimension("stand_off", (0.0, back), (0.0, front)),
                Dimension("wall_thickness", (rim, front), (rim, front + depth)),
                Dimension("wall_radius", (0.0, front + depth), (rim, front + depth)),
            ),
        )


SCENARIO = Scenario(
    name="whipple_shield",
    title="Whipple shield",
    description="A sphere or cylinder breaks up on a bumper, and its debris hits a wall: whether it holds is measured.",
    parameters=WhippleShield,
    materials=("projectile", "bumper", "wall"),
    measurements=(
        "wall_perforated",
        "wall_failed",
        "wall_hole_diameter",
        "wall_crater_depth_over_thickness",
        "wall_bulge",
        "wall_momentum",
        "wall_detached_spall",
        "wall_spall_diameter",
        "wall_spall_velocity",
        "wall_attached_spall",
        "bumper_hole_diameter",
        "shield_tip_velocity",
        "shield_rear_velocity",
        "shield_momentum_behind",
        "shield_kinetic_energy_behind",
    ),
    settles=("bumper_hole_diameter", "wall_perforated", "wall_bulge"),
    least_cells=LEAST_CELLS,
    fewest_cells=FEWEST_CELLS,
)
