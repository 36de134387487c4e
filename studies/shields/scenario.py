"""A Whipple shield: a projectile breaks up on a bumper, and its debris hits a wall behind an empty space.

Each sheet has a stage and a grid of its own, because the space between is a hundred times its thickness. The first is
the impact on the bumper. What comes off leaves its grid as soon as nothing of the bumper can meet it and its own
pressure drives it apart no more, and flies straight. The stage ends when the hole of the bumper has settled and what
is fast enough to come to the next sheet has come off. The next has the next sheet alone, a further bumper or the wall,
at the face of whose grid each particle joins with all of its state at the time of its arrival. Debris whose path misses
that grid stays in the books, and so do the bumper that was hit and what flies back from it.

A body of revolution smears debris off the axis into rings, which load the wall evenly: what single fragments do to it
shows in three dimensions alone.

On the clock of a run each stage goes on where the one before ends: the number ``clock_ahead`` (s) says by how much that
is later, for the wall, than the moment, after the first touch, at which debris comes to its grid.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import accumulate, pairwise, takewhile
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Literal, NamedTuple, Self

from solver.units import Described, Dimensionless, Metre, Second
from studies.debris.breakup import breakup_of
from studies.quantities.findings import Finding
from studies.quantities.numerical_defaults import FEW_PARTICLES, NO_FAILURE, DebrisName
from studies.quantities.parameters import MaterialName, Plain, Value, declared, flat
from studies.quantities.units import readable, round_quantity
from studies.scenarios import Materials, Scenario, Setting, Size
from studies.scenarios.parts.impact import Impact, ImpactSetUp, outline
from studies.scenarios.parts.lattice import SECTORS, along_flight, slab_clamp
from studies.scenarios.parts.numerics import tensions
from studies.scenarios.parts.outline import Dimension, Outline, Shape, number
from studies.scenarios.parts.shot import RADIUS, UPRIGHT, Angles, Settling, Shot
from studies.scenarios.thin_plate import CAP_PER_DIAMETER
from studies.shields.bumpers import BUMPERS, FurtherBumpers
from studies.shields.pieces import sizes_of_pieces
from studies.shields.stages import BumperStage, ShieldSetting

if TYPE_CHECKING:
    from solver.grid.flight import Flight
    from solver.problem import Problem
    from solver.simulation import Outcome
    from solver.state import Snapshot
    from studies.materials import Material
    from studies.sections.section import SectionOptions
    from studies.shields.measurements.shield import ShieldView

# Of the impact speed: what its own pressure may still add to the speed of a piece that leaves the bumper's grid. It
# turns a path by 0.02 rad, which is 2 mm in a flight of 100 mm: the thickness of a wall.
SPREAD = 0.02
# Of the impact speed: matter that is slower has not come to the wall when its stage ends at the latest. It has 4 % of
# the kinetic energy of what comes first.
SLOWEST = 0.2
# Of the way from the first bumper: radius of a sheet that is modelled. Clouds open by 30 degrees to either side and
# less (their largest radius is about half of their length); what flies past is counted.
WALL_RADIUS = math.tan(math.radians(30.0))
# The same where pieces fly to it, in three dimensions: no more than what this share of their momentum meets, which is
# within 18 degrees (5.41 mm at 3, 5 and 7 km/s: 0.18, 0.32 and 0.26 of the way, 2026-11-29).
PIECES_SHARE = 0.9
PIECES_RADIUS = math.tan(math.radians(18.0))
PIECES_CELLS = 8.0  # through a wall that pieces hit, at least
# Width of wall between what pieces hit and the held rim, in thicknesses of the wall: a nearer rim decides how the wall
# moves. 1.59 mm at 5 km/s, 1.7 mm of wall: it bulges by 0.80 of its thickness with none, and by 0.44, 0.48, 0.44 and
# 0.42 with 1, 2, 3 and 4 (2026-11-30; none of them has a hole).
PIECES_RIM = 2.0
# Of the cells across the projectile: through the wall, and each bumper but the first. At 32 across, 8: a hole is within
# 1 % from there on.
WALL_CELLS = 0.25
# Cells of the first bumper in one of these, at most: coarser ones would not resolve a solid piece of the projectile.
WIDEST_CELL = 2.0
# Steps of a later stage over those of its undisturbed state: the viscosity of what flies into it shortens them, by
# six (5 mm of aluminium at 6.5 km/s, 32 cells, 2026-11-25), and the stage settles in half of its time.
WALL_STEPS = 3.0
LEAST_ROOM = 1.0  # behind a bumper, projectile diameters: what comes off needs a place in which it expands
CLEAR_CELLS = 4.0  # least radius of a wall, in cells of it: measurements leave out the three cells next to its rim
LEAST_CELLS: Mapping[str, float] = {"cells_per_diameter": 16.0, "cells_per_thickness": 6.0, "cells_per_wall": 8.0}
FEWEST_CELLS: Mapping[str, float] = {"cells_per_thickness": 2.0, "cells_per_wall": 2.0}


@dataclass(frozen=True)
class Sheet:
    """A bumper or the wall."""

    name: str  # of its body, and of the parameter of its material
    thickness: float  # m
    radius: float  # m: half its width where it is square
    cells: float  # through it
    stand_off: float  # empty space behind it, m; behind a wall it has no end
    aside: float  # place of its middle, in the plane of an oblique flight, from the point of impact, m

    @property
    def cell(self) -> float:
        """Size of a cell, m."""
        return self.thickness / self.cells


@dataclass(frozen=True, kw_only=True)
class AtShield(Shot):
    """A shot at a shield."""

    bumper: Annotated[MaterialName, Described("material of the bumper")]
    wall: Annotated[MaterialName, Described("material of the wall")]
    edges: Annotated[
        Literal["fixed", "free"],
        Described("what holds the rims of bumpers and wall; debris that flies past them leaves the grid"),
    ] = "fixed"
    end_time: Annotated[
        Second | None,
        Described(
            "latest end of the first bumper's stage; by default 7.5 ms per metre of diameter (60 us at 8 mm)", 1e-9, 1.0
        ),
    ] = None
    debris: Annotated[
        DebrisName | None, Described("debris flies straight from sheet to sheet: retire is the one choice")
    ] = "retire"
    uprange: Annotated[
        Dimensionless | None,
        Described(
            "grid in front of bumpers and wall, in projectile diameters; by default that of the recipe", 0.5, 50.0
        ),
    ] = None
    downrange: Annotated[
        Dimensionless | None,
        Described(
            "grid behind bumpers and wall, in projectile diameters; by default that of the recipe, and behind a "
            "bumper no more than the next grid leaves",
            0.5,
            50.0,
        ),
    ] = None


@dataclass(frozen=True, kw_only=True)
class Walls:
    """The first bumper of a shield, its wall, and the space behind that bumper."""

    bumper_thickness: Annotated[Metre, Described("thickness of the bumper", 1e-6, 1.0)]
    stand_off: Annotated[
        Metre,
        Described(
            "space between the back of the bumper and the front of what is next: the wall, or a second bumper",
            1e-4,
            10.0,
        ),
    ]
    wall_thickness: Annotated[Metre, Described("thickness of the wall", 1e-6, 1.0)]
    bumper_radius: Annotated[
        Metre | None,
        Described("radius of a round bumper, half the width of a square one; by default 3.5 diameters", 1e-5, 10.0),
    ] = None
    wall_radius: Annotated[
        Metre | None,
        Described(
            "radius of a round wall, half the width of a square one; by default that of a cone of 30 degrees from the "
            "first bumper, and 3.5 diameters at least; in an oblique shot wider by half of the way between the normal "
            "and the line of flight, midway between which is its middle; where pieces fly, 18 degrees in place of 30, "
            "two thicknesses wider, and no more than two beyond what they hit",
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
    pieces_seed: Annotated[
        int | None,
        Described(
            "draws the pieces as which debris of a body of revolution hits the wall, a quarter in three dimensions, "
            "where its matter opens (tension); with 0 it is an even load of rings",
            0,
            1_000_000,
        ),
    ] = 0
    wall_time: Annotated[
        Second | None,
        Described(
            "latest end of the wall's stage, and of those of further bumpers, after its first debris; by default "
            "7.5 ms per metre of diameter, and what a fifth of the impact speed takes from the first bumper to the "
            "wall",
            1e-9,
            1.0,
        ),
    ] = None

    def filled(self, shot: AtShield, obliquity: float, way: float) -> Self:
        """With all that follows from the shot, its angle, and the way from the first bumper to the wall, m."""
        diameter = shot.projectile_diameter
        cells = cells_through(self.wall_thickness, shot)
        late = CAP_PER_DIAMETER * diameter + way / (SLOWEST * shot.speed * math.cos(obliquity))
        pieces_seed = (self.pieces_seed or None) if shot.geometry == "axisymmetric" else None
        if pieces_seed:
            cells = max(cells, PIECES_CELLS)
        wall = max(RADIUS * diameter, (PIECES_RADIUS if pieces_seed else WALL_RADIUS) * way) + _aside(obliquity, way)
        wall += PIECES_RIM * self.wall_thickness if pieces_seed else 0.0
        return replace(
            self,
            bumper_radius=round_quantity(self.bumper_radius or RADIUS * diameter),
            wall_radius=round_quantity(self.wall_radius or wall),
            cells_per_wall=round_quantity(self.cells_per_wall or cells),
            wall_time=round_quantity(self.wall_time or late),
            pieces_seed=pieces_seed,
        )

    def check(self, shot: AtShield) -> list[Finding]:
        """Sheets are wider than the projectile and no thinner than half a cell."""
        findings, diameter = [], shot.projectile_diameter
        for name, radius in (("bumper_radius", self.bumper_radius), ("wall_radius", self.wall_radius)):
            assert radius is not None
            if radius < diameter:
                limit = f"at least the projectile's diameter, {readable(diameter, 'm')}"
                findings.append(Finding(name, readable(radius, "m"), limit, f"leave {name} out"))
        cell = self.wall_thickness / (self.cells_per_wall or cells_through(self.wall_thickness, shot))
        if (self.wall_radius or 0.0) < CLEAR_CELLS * cell:
            limit = f"at least {CLEAR_CELLS:g} cells of the wall, {readable(CLEAR_CELLS * cell, 'm')}"
            findings.append(
                Finding("wall_radius", readable(self.wall_radius or 0.0, "m"), limit, "raise cells_per_wall")
            )
        if self.bumper_thickness < 0.5 * shot.cell:
            limit = f"at least half a cell, {readable(0.5 * shot.cell, 'm')}"
            cure = "raise the resolution (cells per diameter)"
            findings.append(Finding("bumper_thickness", readable(self.bumper_thickness, "m"), limit, cure))
        return findings


def cells_through(thickness: float, shot: AtShield) -> float:
    """Cells through a sheet (m) behind the first bumper, by default."""
    return max(WALL_CELLS * shot.cells_per_diameter, thickness / (WIDEST_CELL * shot.cell))


class Layer(NamedTuple):
    """A bumper, and the space behind it."""

    name: str
    thickness: float  # m
    space: float  # m


def _layers(values: Mapping[str, Plain]) -> list[Layer]:
    """The bumpers of parameters by name, the outermost first."""
    spaces = ("stand_off", *(f"{name}_stand_off" for name in BUMPERS[1:]))
    layers = (
        Layer(name, number(values, f"{name}_thickness"), number(values, space))
        for name, space in zip(BUMPERS, spaces, strict=True)
    )
    return list(takewhile(lambda layer: layer.thickness, layers))


def _ways(layers: list[Layer]) -> list[float]:
    """The way (m) from the back of the first bumper to the front of each sheet behind it, the wall last."""
    spaces = accumulate(layer.space for layer in layers)
    thicknesses = accumulate((layer.thickness for layer in layers[1:]), initial=0.0)
    return [space + thickness for space, thickness in zip(spaces, thicknesses, strict=True)]


@dataclass(frozen=True, kw_only=True)
class WhippleShield(ImpactSetUp[ShieldSetting, "ShieldView"]):
    """Parameters of a shield."""

    experienced = MappingProxyType({"bumper_hole_diameter": "hole_diameter"})
    of_shot = frozenset({*ImpactSetUp.of_shot, *declared(Walls), *declared(FurtherBumpers), "bumper", "wall"})

    shot: AtShield
    settling: Settling
    angles: Angles
    walls: Walls
    further: FurtherBumpers

    @property
    def impact(self) -> Impact:
        """The projectile in front of the first bumper, on a grid that ends before that of the next sheet."""
        assert self.walls.bumper_radius is not None
        assert self.shot.downrange is not None
        shot = replace(self.shot, downrange=min(self.shot.downrange, self._room(0)))
        return Impact(
            replace(self, shot=shot),
            thickness=self.walls.bumper_thickness,
            radius=self.walls.bumper_radius,
            target="bumper",
            expansion=0.5 * (SPREAD * self.shot.speed) ** 2,
        )

    def target(self, number: int, *, flat: bool = False) -> Impact:
        """A sheet on a grid of its own; the projectile is there for the first one alone.

        A wall that pieces hit is a quarter in three dimensions, or ``flat`` the grid to which they fly.
        """
        if number == 0:
            return self.impact
        sheet = self.sheets[number]
        assert self.shot.downrange is not None
        numerics, geometry = self.numerics, self.shot.geometry
        if self.has_pieces and number + 1 == self.stages and not flat:
            numerics, geometry = replace(numerics, particles_per_cell=FEW_PARTICLES), "quarter"
        shot = replace(
            self.shot,
            geometry=geometry,
            cells_per_diameter=sheet.cells * self.shot.projectile_diameter / sheet.thickness,
            end_time=self.walls.wall_time,
            downrange=min(self.shot.downrange, self._room(number)),
        )
        parameters = replace(self, shot=shot, angles=UPRIGHT, numerics=numerics)
        return replace(
            self.impact, parameters=parameters, thickness=sheet.thickness, radius=sheet.radius, target=sheet.name
        )

    @property
    def sheets(self) -> tuple[Sheet, ...]:
        """The bumpers, the outermost first, and the wall."""
        walls, shot, layers = self.walls, self.shot, self._layers
        assert walls.bumper_radius is not None
        assert walls.wall_radius is not None
        assert walls.cells_per_wall is not None
        ways, lean = _ways(layers), self.angles.obliquity
        through = walls.bumper_thickness / shot.cell
        first = Sheet("bumper", walls.bumper_thickness, walls.bumper_radius, through, walls.stand_off, aside=0.0)
        further = [
            Sheet(
                name,
                thickness,
                radius=walls.bumper_radius + WALL_RADIUS * way + _aside(lean, way),
                cells=cells_through(thickness, shot),
                stand_off=space,
                aside=_aside(lean, way),
            )
            for (name, thickness, space), way in zip(layers[1:], ways[:-1], strict=True)
        ]
        size = walls.wall_thickness, walls.wall_radius, walls.cells_per_wall
        return first, *further, Sheet("wall", *size, stand_off=math.inf, aside=_aside(lean, ways[-1]))

    @property
    def has_pieces(self) -> bool:
        """Whether debris comes to the wall as pieces."""
        return bool(self.walls.pieces_seed)

    @property
    def stages(self) -> int:
        return len(self._layers) + 1

    @property
    def _layers(self) -> list[Layer]:
        return _layers({**vars(self.walls), **flat(self.further)})

    @staticmethod
    def lacking(values: Mapping[str, Value]) -> tuple[str, ...]:
        """The bumpers that have no thickness, and those behind them."""
        return BUMPERS[len(_layers(values)) :]

    def _before(self, sheet: Sheet) -> float:
        """Grid in front of a sheet behind the first at most, in projectile diameters: that of ``Impact.grid``."""
        shot = self.shot
        assert shot.uprange is not None
        before = max(shot.uprange * shot.projectile_diameter, shot.length + 2.0 * sheet.cell) + sheet.cell
        return before / shot.projectile_diameter

    def _room(self, number: int) -> float:
        """Room between a sheet and the next grid, in projectile diameters; without end behind the wall."""
        sheets = self.sheets
        if number + 1 == len(sheets):
            return math.inf
        return sheets[number].stand_off / self.shot.projectile_diameter - self._before(sheets[number + 1])

    def filled(self, materials: Materials) -> Self:
        diameter = self.shot.projectile_diameter
        return replace(
            # Of matter that never breaks; void-growth tells more shots right (docs/pages/simulated_shields.py).
            self.with_shot(materials, end_time=CAP_PER_DIAMETER * diameter, failure=NO_FAILURE),
            settling=self.settling.filled(diameter),
            walls=self.walls.filled(self.shot, self.angles.obliquity, _ways(self._layers)[-1]),
            further=self.further.filled(),
        )

    def check(self, materials: Materials) -> list[Finding]:
        findings = [*self.further.check()] or [*self._refused()]
        if findings:
            return findings
        return [*super().check(materials), *self.walls.check(self.shot)]

    def _refused(self) -> Iterator[Finding]:
        """What stages cannot compute, by name."""
        if self.shot.debris != "retire":
            limit = "retire: followed debris does not come to the wall"
            yield Finding("debris", str(self.shot.debris), limit, "leave debris out")
        rule = str(self.numerics.choices.tension)
        if self.has_pieces and not tensions()[rule].opens:
            limit = f"0 with tension {rule}, of which nothing parts"
            yield Finding("pieces_seed", str(self.walls.pieces_seed), limit, "set tension to opening")
        for place, (sheet, behind) in enumerate(pairwise(self.sheets)):
            if self._room(place) >= LEAST_ROOM - 1e-9:
                continue
            least = (LEAST_ROOM + self._before(behind)) * self.shot.projectile_diameter
            away = readable(round_quantity(least), "m")
            limit = f"at least the grid in front of {behind.name} and {LEAST_ROOM:g} projectile diameter, {away}"
            cure = "reduce uprange, or compute the sheets on one grid as a deck"
            name = "stand_off" if place == 0 else f"{sheet.name}_stand_off"
            yield Finding(name, readable(sheet.stand_off, "m"), limit, cure)

    def build(self, materials: Materials) -> Setting:
        setting = vars(self.impact.build(materials))
        normal_speed = self.shot.speed * math.cos(self.angles.obliquity)
        [projectile] = [body for body in setting["problem"].bodies if body.name == "projectile"]
        return ShieldSetting(
            **{**setting, "settles": self._settles(0)},
            breakup=(),  # no size of fragments is measured
            melting=(),  # and no melted share
            bumpers=self.stages - 1,
            slowest=SLOWEST * normal_speed,
            momentum=float(projectile.mass.sum()) * normal_speed,
        )

    @staticmethod
    def view(setting: ShieldSetting, snapshot: "Snapshot") -> "ShieldView":
        from studies.shields.measurements.shield import view

        return view(setting, snapshot)

    def _settles(self, number: int) -> tuple[str, ...]:
        """What the stage of a sheet waits for."""
        last = number == self.stages - 1
        return ("wall_perforated", "wall_bulge") if last else (f"{BUMPERS[number]}_hole_diameter",)

    def next_stage(self, setting: ShieldSetting, outcome: "Outcome", materials: Materials) -> ShieldSetting | None:
        """The next sheet, to which the debris of a bumper flies."""
        number = len(setting.before)
        if number + 1 == self.stages:
            return None
        from solver.state import MASS
        from studies.shields.measurements.shield import view

        target, flight, sector, piece = self._flown(number, setting, outcome, materials)
        before, snapshot, seen = setting.problem, outcome.snapshot, view(setting, outcome.snapshot)
        scale = sector / setting.sector
        ended = BumperStage(
            bumper=seen.bumpers[-1],
            cloud=seen.cloud,
            mass=sum(float(body.mass.sum()) for body in before.bodies),
            coming=float(flight.arrivals.table[MASS].sum()),
            missed=flight.missed / scale,
            attached=max(seen.attached, seen.coming if setting.before else 0.0),
            clock_ahead=flight.ahead,
            angular_momentum_error=flight.angular_momentum_error,
            piece=piece,
        )
        return replace(
            setting,
            problem=self._problem_behind(target, materials[target.target], before, flight, begin=snapshot.time),
            sector=sector,
            momentum=scale * setting.momentum,
            target=target.target,
            thickness=target.thickness,
            radius=target.radius,
            settles=self._settles(number + 1),
            before=(*setting.before, ended),
        )

    def _flown(
        self, number: int, setting: ShieldSetting, outcome: "Outcome", materials: Materials
    ) -> "tuple[Impact, Flight, float, float | None]":
        """The next sheet, what flies to it from the sheet ``number``, the sector (rad) of its stage, size of pieces."""
        from solver.grid.flight import fly
        from solver.grid.pieces import median, radius_of, scatter

        (hit, behind), before = self.sheets[number : number + 2], setting.problem
        shift = along_flight(self.shot.geometry, hit.thickness + hit.stand_off)
        shift[0] = behind.aside - hit.aside

        def flight_to(sheet: Impact) -> "Flight":
            geometry, _ = sheet.grid()
            bodies = len(before.bodies) + 1
            return fly(before, outcome.snapshot, outcome.books, geometry=geometry, shift=shift, bodies=bodies)

        target = self.target(number + 1)
        if not self.has_pieces or number + 2 < self.stages:
            return target, flight_to(target), setting.sector, None
        widest = self.target(number + 1, flat=True)
        radius = radius_of(flight_to(widest).arrivals, PIECES_SHARE) + PIECES_RIM * target.thickness
        radius = min(widest.radius, max(CLEAR_CELLS * target.shot.cell, radius))
        flight = flight_to(replace(widest, radius=radius))
        sizes = sizes_of_pieces(before, flight, [breakup_of(materials[body.name]) for body in before.bodies])
        seed = self.walls.pieces_seed or 0
        scattered = scatter(before, flight, sizes, spacing=target.step, seed=seed)
        return replace(target, radius=radius), scattered.flight, SECTORS["quarter"], median(scattered.diameter)

    def _problem_behind(
        self, target: Impact, material: "Material", before: "Problem", flight: "Flight", *, begin: float
    ) -> "Problem":
        """A sheet and, still without particles, the bodies of the stage ``before``; its clock begins at a time (s)."""
        import numpy as np

        from solver.problem import Problem, Retirement

        geometry, faces = target.grid()
        nothing, still = np.zeros(0), np.zeros(3)
        gone = [replace(body, position=np.zeros((0, 3)), velocity=still, mass=nothing) for body in before.bodies]
        problem = Problem(
            geometry=geometry,
            bodies=(*gone, target.body(target.target, material, geometry, *target.points(), still)),
            faces=faces,
            clamp=slab_clamp(target.shot.geometry, target.thickness, target.shot.cell),
            start_time=begin,
            end_time=begin + target.end_time,
            retirement=Retirement(body=len(gone), after=begin + target.clear, expansion=target.expansion),
            arrivals=flight.arrivals,
            books=flight.books,
        )
        return target.parameters.numerics.applied_to(problem)

    def size(self, materials: Materials) -> Size:
        """The most particles of a stage, and as many steps as give the work of all."""
        first, *later = (self.target(number).size() for number in range(self.stages))
        most = max(stage.particles for stage in (first, *later))
        work = first.particles * first.steps + sum(WALL_STEPS * stage.particles * stage.steps for stage in later)
        return Size(particles=most, steps=round(work / most))

    def cells(self) -> dict[str, float]:
        """Cells across the projectile, through the bumper that has the fewest, and through the wall."""
        *bumpers, wall = (sheet.cells for sheet in self.sheets)
        return {**self.impact.cells(), "cells_per_thickness": min(bumpers), "cells_per_wall": wall}

    @staticmethod
    def numbers(view: "ShieldView") -> dict[str, float]:
        """What missed the next grid, the clock, cells across a piece, and whether flights kept angular momentum."""
        numbers = {"missed_mass_fraction": view.missed, "clock_ahead": view.clock_ahead}
        if view.piece is not None:
            numbers["cells_per_piece"] = view.piece / view.cell
        if view.angular_momentum_error is not None:
            numbers["flight_angular_momentum_error"] = view.angular_momentum_error
        return numbers

    def sections(self, setting: ShieldSetting) -> "SectionOptions":
        from studies.sections.section import SectionOptions

        return SectionOptions() if setting.before else super().sections(setting)

    @staticmethod
    def outline(values: Mapping[str, Plain]) -> Outline | None:
        before = outline(values, thickness="bumper_thickness", radius="bumper_radius", target="bumper")
        depth, rim = number(values, "wall_thickness"), number(values, "wall_radius")
        if before is None or not number(values, "stand_off") or not depth or not rim:
            return None
        shapes, dimensions, back = [*before.shapes], [*before.dimensions], number(values, "bumper_thickness")
        layers, lean = _layers(values), number(values, "obliquity")
        ways = _ways(layers)
        front = back + layers[0][2]
        dimensions.append(Dimension("stand_off", (0.0, back), (0.0, front)))
        for (name, thickness, space), way in zip(layers[1:], ways, strict=False):
            aside, back = _aside(lean, way), front + thickness
            edge = number(values, "bumper_radius") + WALL_RADIUS * way + aside
            shapes.append(Shape(name, aside - edge, aside + edge, front, back))
            dimensions.append(Dimension(f"{name}_thickness", (aside + edge, front), (aside + edge, back)))
            dimensions.append(Dimension(f"{name}_stand_off", (0.0, back), (0.0, back + space)))
            front = back + space
        aside, back = _aside(lean, ways[-1]), front + depth
        shapes.append(Shape("wall", aside - rim, aside + rim, front, back))
        dimensions += [
            Dimension("wall_thickness", (aside + rim, front), (aside + rim, back)),
            Dimension("wall_radius", (aside, back), (aside + rim, back)),
        ]
        return Outline(tuple(shapes), tuple(dimensions))


def _aside(obliquity: float, way: float) -> float:
    """Midway (m) between the normal and the line of flight some way (m) behind the first bumper.

    Debris of an oblique shot flies in two clouds about these two, and between them.
    """
    return 0.5 * math.tan(obliquity) * way


SCENARIO = Scenario(
    name="whipple_shield",
    title="Whipple shield",
    description="A sphere or cylinder breaks up on bumpers, and its debris hits a wall: whether it holds is measured.",
    question="Does the wall of a shield hold?",
    place=30,
    parameters=WhippleShield,
    materials=("projectile", *BUMPERS, "wall"),
    first=(
        *("wall_perforated", "wall_failed", "wall_hole_diameter"),
        *("wall_crater_depth_over_thickness", "wall_bulge", "bumper_hole_diameter"),
    ),
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
        *(f"{name}_hole_diameter" for name in BUMPERS),
        "shield_tip_velocity",
        "shield_rear_velocity",
        "shield_momentum_behind",
        "shield_kinetic_energy_behind",
    ),
    of_role={f"{name}_hole_diameter": name for name in BUMPERS[1:]},
    settles=("bumper_hole_diameter", "wall_perforated", "wall_bulge"),
    accurate=("bumper_hole_diameter",),
    least_cells=LEAST_CELLS,
    fewest_cells=FEWEST_CELLS,
)
