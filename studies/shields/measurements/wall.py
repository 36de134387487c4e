"""The wall of a shield under debris: whether it has a clear hole, what came off its back, how deep it is cratered.

The wall is looked at in columns of cells along its normal: rings one cell wide of a body of revolution, squares in
three dimensions. Two of its particles that have not failed hang together when their cells are the same or neighbours,
as for the solver, and what hangs together, through its own matter, with what stood at its rim at rest is the connected
wall: also where that has drawn away from what holds it (``rim_moved``). Other matter of the wall is free: it is spall
where it flies on and no connected wall stands behind it in its column. So matter that a crater throws out, or that lies
in one, is none; a plug that came out of a hole is. What has departed from the grid counts as it flew away.

Light passes through a column without any particle of the connected wall. A ring of such columns leaves nothing
connected within it: in a body of revolution the innermost column alone tells a hole, which a plug leaves too.

The thickness of a column is its mass of connected wall, each particle spread over a cell, over that of the undisturbed
wall, read alike. So neither a bulge, a void nor the lattice changes it. A ligament thinner than a cell is one that the
grid may hold together, or tear, by itself (``closed_by_film``).

Failure of a shield is a perforation or detached spall (Christiansen et al. 2009, NASA/TM-2009-214785, section 4): a
shield may fail and have no hole, so both outcomes stand here, by names of their own.
"""

import math
from dataclasses import dataclass, replace
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from studies.measurements import Measurement, NoValue, OnGrid, Reading, measurement
from studies.measurements._settings import ImpactSetting
from studies.measurements.hole import hole_diameter as plate_hole
from studies.measurements.impact.view import ImpactView, hanging_together
from studies.measurements.impact.view import view as impact_view
from studies.quantities.measured import CLOSED_BY_FILM, STILL_ATTACHED, STILL_COMING

if TYPE_CHECKING:
    from solver.state import Snapshot

NOT_REACHED = "not_reached"  # no debris has come to the wall yet
LATE = 0.01  # of the mass that flies to the wall: while more is to come the wall has not settled
# Of the mass of wall that a projectile diameter covers: what is less is no spall, or no void, that a person would look
# for; a cube of a sixth of the diameter where the wall is half as thick.
LEAST = 0.01
RIM = 3.0  # cells from the rim in which no column is looked at
HELD = 2.0  # cells from the rim, whose matter is held there


@dataclass(frozen=True, eq=False)
class Wall(OnGrid):
    """All matter of a wall, on the grid and departed, in columns of whole bodies of revolution or their parts."""

    plate: ImpactView  # the same wall as the plate of an impact, for its hole
    place: np.ndarray  # (n, 1 or 2) m in the plane of the wall
    first_place: np.ndarray  # the same at rest
    depth: np.ndarray  # (n,) m behind the original front surface
    first_depth: np.ndarray  # (n,) the same at rest
    velocity: np.ndarray  # (n,) along the flight, m/s
    mass: np.ndarray  # (n,) kg, of whole bodies
    line: np.ndarray  # (n,) index of the line of particles along the normal in which it stood at rest
    attached: np.ndarray  # (n,) whether it is connected wall
    given: float  # momentum along the flight that debris has brought and does not have any more, N s
    columns: tuple[int, ...]  # of the grid along the axes of the plane
    lower: tuple[float, ...]  # where they begin, m; 0 is a plane of symmetry, or the axis
    copies: float  # of the model in a whole body of three dimensions; 1 of a body of revolution
    cell: float  # m
    width: float  # of a particle along the normal, m
    density: float  # undisturbed, kg/m3
    thickness: float  # undisturbed, m
    radius: float  # to the rim, m
    projectile_diameter: float  # m
    age: float  # time since its stage began, s
    rim_moved: bool  # whether nothing of it stands at its rim any more

    @property
    def covered(self) -> float:
        """Volume of the wall that a projectile diameter covers, m3."""
        return 0.25 * math.pi * self.projectile_diameter**2 * self.thickness

    @property
    def column(self) -> np.ndarray:
        """(n,) Index of the column in which each particle stands."""
        return self._column(self.place)

    @property
    def first_column(self) -> np.ndarray:
        """(n,) Index of the column in which each particle stood at rest."""
        return self._column(self.first_place)

    def _column(self, place: np.ndarray) -> np.ndarray:
        index = np.clip(((place - self.lower) / self.cell).astype(np.int64), 0, np.array(self.columns) - 1)
        return np.ravel_multi_index(tuple(index.T), self.columns)

    @property
    def within(self) -> np.ndarray:
        """(columns,) Whether a column is clear of the rim."""
        last, clear = self.radius - RIM * self.cell, []
        for lower, count in zip(self.lower, self.columns, strict=True):
            edges = lower + self.cell * np.arange(count + 1.0)
            clear.append((edges[1:] <= last) & ((edges[:-1] >= -last) | (lower == 0.0)))
        return np.logical_and.reduce(np.meshgrid(*clear, indexing="ij")).ravel()

    @property
    def is_clear(self) -> np.ndarray:
        """(columns,) Whether no particle of the connected wall stands in a column within the rim."""
        clear: np.ndarray = np.bincount(self.column[self.attached], minlength=math.prod(self.columns)) == 0
        return clear & self.within

    @property
    def is_perforated(self) -> bool:
        """Whether light passes through a column."""
        return bool(self.is_clear.any())

    @property
    def share(self) -> np.ndarray:
        """(columns within the rim,) Thickness of the connected wall over that of the undisturbed wall."""
        return self._over_whole(self.place, self.attached)

    def _over_whole(self, place: np.ndarray, among: np.ndarray) -> np.ndarray:
        """Mass of some particles (n, bool) at places, over that of all at rest, in each column within the rim."""
        part, whole = self._spread(place[among], self.mass[among]), self._spread(self.first_place, self.mass)
        return part[self.within] / whole[self.within]

    def _spread(self, place: np.ndarray, mass: np.ndarray) -> np.ndarray:
        """Mass (columns,) of particles that are each spread over a cell, kg; planes of symmetry mirror it."""
        middle = (place - self.lower) / self.cell - 0.5
        below = np.floor(middle)
        part = middle - below
        total = np.zeros(math.prod(self.columns))
        for corner in product((0, 1), repeat=len(self.columns)):
            share = np.where(corner, part, 1.0 - part).prod(axis=1)
            index = np.clip(below + corner, 0, np.array(self.columns) - 1).astype(np.int64)
            np.add.at(total, np.ravel_multi_index(tuple(index.T), self.columns), mass * share)
        return total

    def _rearmost(self, column: np.ndarray, depth: np.ndarray) -> np.ndarray:
        """The largest depth (n,) of the connected wall in each of the columns (n,), minus infinity without any; m."""
        largest = np.full(int(np.max(column, initial=0)) + 1, -math.inf)
        np.maximum.at(largest, column[self.attached], depth[self.attached])
        return largest[column]

    @property
    def spall(self) -> np.ndarray:
        """(n,) Whether it is free, flies on, and no connected wall stands behind it."""
        back = np.maximum(self._rearmost(self.column, self.depth), 0.0)
        return ~self.attached & (self.velocity > 0.0) & (self.depth > back)

    @property
    def cratered(self) -> float:
        """The largest part of a column that is missing; without what stood behind all that is left of its own line."""
        behind = self.first_depth > self._rearmost(self.line, self.first_depth)
        came_off = self._over_whole(self.first_place, behind & ~self.attached)
        return max(0.0, float((1.0 - self.share - came_off).max()))

    @property
    def is_spalled(self) -> bool:
        """Whether there is more spall than ``LEAST``."""
        return bool(self.mass[self.spall].sum() > LEAST * self.covered * self.density)

    @property
    def on_face(self) -> np.ndarray:
        """(n,) Whether it was the last layer of particles at the rear face."""
        return self.first_depth > self.thickness - self.width

    @property
    def void(self) -> float:
        """Volume within the connected wall, cells that no way over faces of empty cells joins with the outside; m3."""
        from scipy import ndimage

        row = np.floor(self.depth[self.attached] / self.cell).astype(np.int64)
        if not row.size:
            return 0.0
        occupied = np.zeros((math.prod(self.columns), int(np.ptp(row)) + 1), bool)
        occupied[self.column[self.attached], row - row.min()] = True
        # Outside are both sides along the normal and all beyond the rim; none is behind a plane of symmetry.
        beyond = [*((int(lower < 0.0), 1) for lower in self.lower), (1, 1)]
        empty = np.pad(~occupied.reshape(*self.columns, -1), beyond, constant_values=1)
        label, _ = ndimage.label(empty)
        count = ((label > 0) & (label != label[(-1,) * label.ndim])).sum(axis=-1)
        # Of a body of revolution the cells are rings, whose length grows from the axis outwards.
        length = 2.0 * math.pi * self.cell * (np.arange(count.size) + 0.5) if len(self.columns) == 1 else self.copies
        return float((count * (length * self.cell ** (1 + len(self.columns)))).sum())


@dataclass(frozen=True)
class WallView(OnGrid):
    """A wall, and the debris that has yet to come to it."""

    wall: Wall | None  # None before the first of it
    coming: float  # the larger part: of the mass that waits to join the grid, of the momentum on its way across it
    held_back: bool  # whether more than ``LATE`` of what flies to it had not come off a sheet in front
    cell: float  # m


def wall_of(setting: ImpactSetting, snapshot: "Snapshot") -> Wall:
    """The wall of a snapshot, in a setting whose target it is."""
    from solver.grid.debris import flown
    from solver.problem.geometry import impact_axis
    from solver.state import MASS, VX

    problem, particles, departed = setting.problem, snapshot.particles, snapshot.departed
    axis, plate, cell = impact_axis(problem.geometry), impact_view(setting, snapshot), problem.geometry.spacing
    number = [body.name for body in problem.bodies].index(setting.target)
    body, copies = problem.bodies[number], 2.0 * math.pi / setting.sector
    here = np.flatnonzero((particles.alive == 1) & (snapshot.body == number))
    gone = np.flatnonzero(departed.body == number)
    start = sum(body.mass.size for body in problem.bodies[:number])

    def whole(name: str) -> np.ndarray:
        return np.concatenate([getattr(particles, name)[here], getattr(departed, name)[gone]])

    position = np.concatenate([particles.position[here], flown(problem, departed, snapshot.time)[gone]])
    first = body.position[whole("number") - start]
    on_grid, unbroken = plate.target, particles.damage[particles.alive == 1] < 1.0
    seed = np.zeros(on_grid.size, bool)
    seed[on_grid] = np.abs(first[: here.size, :axis]).max(axis=1) > setting.radius - HELD * cell
    among = on_grid & unbroken
    attached = hanging_together(problem.geometry, particles.position[particles.alive == 1], among, seed)
    lines = np.floor(first[:, :axis] / body.spacing[:axis]).astype(np.int64)
    lines -= lines.min(axis=0, initial=0)
    other = (particles.alive == 1) & (snapshot.body != number)
    given = -float((particles.mass[other] * particles.velocity[other, axis]).sum())
    given -= float((departed.mass * departed.velocity[:, axis])[departed.body != number].sum())
    if problem.arrivals is not None:
        # They join in order, with the last numbers of all.
        start_of_arrivals = problem.particle_count - problem.arrivals.time.size
        last = max(np.max(matter.number, initial=-1) for matter in (particles, departed))
        table = problem.arrivals.table[:, : max(0, int(last) + 1 - start_of_arrivals)]
        given += float((table[MASS] * table[VX + axis]).sum())
    return Wall(
        plate=replace(plate, attached_target=attached),
        place=position[:, :axis],
        first_place=first[:, :axis],
        depth=position[:, axis],
        first_depth=first[:, axis],
        velocity=whole("velocity")[:, axis],
        mass=copies * whole("mass"),
        line=np.ravel_multi_index(tuple(lines.T), tuple(lines.max(axis=0, initial=0) + 1)),
        attached=np.concatenate([attached[on_grid], np.zeros(gone.size, bool)]),
        given=copies * given,
        columns=tuple(int(count) for count in problem.geometry.cells[:axis]),
        lower=tuple(map(float, problem.geometry.lower[:axis])),
        copies=1.0 if axis == 1 else copies,
        cell=cell,
        width=body.spacing[axis],
        density=body.density,
        thickness=setting.thickness,
        radius=setting.radius,
        projectile_diameter=setting.projectile_diameter,
        age=snapshot.time - problem.start_time,
        rim_moved=not plate.attached_target.any(),
    )


def _of_wall(of_wall: Measurement) -> Measurement:
    """A measurement of a wall as one of a shield.

    It is not reached before there is debris at the wall. It says while more is coming, where more would come that still
    hangs on a sheet in front, and where the rim has moved, unless it is an outcome that nothing undoes.
    """

    def read(view: WallView) -> Reading:
        if view.wall is None:
            raise NoValue(NOT_REACHED)
        reading = of_wall.read(view.wall)
        if of_wall.is_outcome and reading.value == 1.0:
            return reading
        doubts = {STILL_COMING: view.coming > LATE, STILL_ATTACHED: view.held_back, "rim_moved": view.wall.rim_moved}
        return replace(reading, flags=(*reading.flags, *(flag for flag, holds in doubts.items() if holds)))

    return replace(of_wall, definition=read)


# ---- outcomes ------------------------------------------------------------------------------------


def _doubt(wall: Wall) -> tuple[str, ...]:
    """The flag of a wall without a hole, whose thinnest column has less matter than a cell would."""
    return (CLOSED_BY_FILM,) if wall.share.min() * wall.thickness < wall.cell else ()


@_of_wall
@measurement(
    title="Wall perforated",
    unit="1",
    meaning="1 where light passes through the wall along its normal: at least one column of cells, three cells from "
    "the rim or more, has no particle of the wall that is connected to its rim through matter that has not failed; "
    "else 0. A plug that came out leaves a hole. Closed by film where a wall without a hole has a column with less "
    "matter than fills a cell",
    version=3,
    outcomes=("wall holds", "wall perforated"),
)
def wall_perforated(wall: Wall) -> Reading:
    clear = wall.is_perforated
    return Reading(float(clear), flags=() if clear else _doubt(wall))


@_of_wall
@measurement(
    title="Wall failed",
    unit="1",
    meaning="1 where the wall is perforated, or has detached spall of more than 1 % of the mass of wall that the "
    "diameter of the projectile covers; else 0: the criterion of ballistic limits, no perforation and no detached "
    "spall. Closed by film as for a perforation",
    version=2,
    outcomes=("wall does not fail", "wall fails"),
)
def wall_failed(wall: Wall) -> Reading:
    failed = wall.is_perforated or wall.is_spalled
    return Reading(float(failed), flags=() if failed else _doubt(wall))


@_of_wall
@measurement(
    title="Attached spall",
    unit="1",
    meaning="1 where the wall that is connected to its rim encloses empty cells, no face of which leads outside, of "
    "more than 1 % of the volume of wall that the diameter of the projectile covers: it has parted behind the crater "
    "and nothing came off there; else 0. A crack that is narrower than a cell is not seen, and one that opens into "
    "the crater or to the back is none",
    version=2,
    outcomes=("no attached spall", "attached spall"),
)
def wall_attached_spall(wall: Wall) -> Reading:
    return Reading(float(wall.void > LEAST * wall.covered))


# ---- the hole and the crater ---------------------------------------------------------------------


@_of_wall
@measurement(
    title="Hole of the wall",
    unit="m",
    meaning=f"of a perforated wall: {plate_hole.meaning}; too narrow where the hole is narrower than this tells",
    version=plate_hole.version,
    widest=plate_hole.widest,
)
def wall_hole_diameter(wall: Wall) -> Reading:
    if not wall.is_perforated:
        raise NoValue("not_perforated")
    reading = plate_hole.read(wall.plate)
    if "not_perforated" in reading.flags:
        raise NoValue("too_narrow")
    return reading


@_of_wall
@measurement(
    title="Crater depth over wall thickness",
    unit="1",
    meaning="thickness that the deepest crater takes from the wall, over its original thickness: of all columns of "
    "cells that are three or more from the rim the largest part that is neither in the wall which is connected to its "
    "rim nor came off its rear: that is free, and stood at rest behind all that is left of its line of particles; 1 "
    "where it is perforated",
    version=2,
)
def wall_crater_depth_over_thickness(wall: Wall) -> Reading:
    return Reading(1.0 if wall.is_perforated else wall.cratered, {"resolution": wall.resolution / wall.thickness})


@_of_wall
@measurement(
    title="Bulge of the wall",
    unit="m",
    meaning="largest displacement along the flight of the wall's rear face: mean of its last layer of particles that "
    "is connected to the rim, over a column of cells at rest, the largest of all columns; no wall where none is left; "
    "still moving where its present velocity would have taken it a cell or more in the time of the wall's stage",
    version=3,
)
def wall_bulge(wall: Wall) -> Reading:
    mine = wall.on_face & wall.attached
    if not mine.any():
        raise NoValue("no_wall")
    column, size = wall.first_column[mine], math.prod(wall.columns)
    mass = np.bincount(column, wall.mass[mine], size)
    displacement, velocity = (
        np.bincount(column, (wall.mass * of)[mine], size)[mass > 0.0] / mass[mass > 0.0]
        for of in (wall.depth - wall.first_depth, wall.velocity)
    )
    farthest = int(displacement.argmax())
    flags = ("still_moving",) if abs(velocity[farthest]) * wall.age > wall.cell else ()
    return Reading(float(displacement[farthest]), {"resolution": wall.resolution}, flags)


@_of_wall
@measurement(
    title="Momentum of the wall",
    unit="N s",
    meaning="momentum along the flight that the wall which is connected to its rim has or has given to the rim: what "
    "debris brought to the wall, less that of all debris and of all free matter of the wall, departed included; of "
    "whole bodies",
    version=2,
)
def wall_momentum(wall: Wall) -> Reading:
    """The balance: only the rim takes momentum along the flight from all that is there."""
    free = ~wall.attached
    return Reading(wall.given - float((wall.mass[free] * wall.velocity[free]).sum()))


# ---- spall ---------------------------------------------------------------------------------------


def _spalled_face(wall: Wall) -> float:
    """Area of the rear face that came off as spall, m2."""
    return float(wall.mass[wall.spall & wall.on_face].sum()) / (wall.density * wall.width)


@_of_wall
@measurement(
    title="Detached spall",
    unit="kg",
    meaning="mass of the wall's matter that is not connected to its rim, flies on, and has no connected wall behind it "
    "in its column of cells; what came out of a hole included; of whole bodies",
    version=2,
)
def wall_detached_spall(wall: Wall) -> Reading:
    """The mass; its edge is known to a cell over the part of the rear face that came off."""
    mass = float(wall.mass[wall.spall].sum())
    return Reading(mass, {"resolution": wall.density * _spalled_face(wall) * wall.resolution})


@_of_wall
@measurement(
    title="Diameter of the spalled face",
    unit="m",
    meaning="equal-area diameter of the part of the rear face that came off: of the last layer of particles, at rest, "
    "that is detached spall; no spall where the wall has less than 1 % of the mass that the projectile covers",
    version=2,
)
def wall_spall_diameter(wall: Wall) -> Reading:
    if not wall.is_spalled:
        raise NoValue("no_spall")
    return Reading(math.sqrt(4.0 / math.pi * _spalled_face(wall)), {"resolution": wall.resolution})


@_of_wall
@measurement(
    title="Velocity of the spall",
    unit="m s-1",
    meaning="mean velocity along the flight, by mass, of detached spall; no spall as for the diameter of its face",
    version=2,
)
def wall_spall_velocity(wall: Wall) -> Reading:
    if not wall.is_spalled:
        raise NoValue("no_spall")
    mass = wall.mass[wall.spall]
    return Reading(float((mass * wall.velocity[wall.spall]).sum() / mass.sum()))


MEASUREMENT = (
    wall_perforated,
    wall_failed,
    wall_hole_diameter,
    wall_crater_depth_over_thickness,
    wall_bulge,
    wall_momentum,
    wall_detached_spall,
    wall_spall_diameter,
    wall_spall_velocity,
    wall_attached_spall,
)
