"""Records of the decks of MPM3D: what was read, in SI, and what may be read."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NoReturn

from studies.quantities.findings import Finding, InvalidInput
from studies.quantities.numerical_defaults import SchemeName

MOST_PARTICLES = 20_000_000
MOST_NODES = 50_000_000
Vector = tuple[float, float, float]
Units = Literal["mm-g-ms", "SI"]
ParticleRow = tuple[int, float, float, float, float]  # number in the deck, x, y, z (m) and mass (kg, 0: by ``ppc``)


@dataclass(frozen=True)
class DeckMaterial:
    """A row of the table of materials, with its equation of state; SI."""

    kind: str
    values: Mapping[str, float]
    line: int
    eos: str = ""  # "polynomial", "gruneisen", "jwl"; "" without
    eos_values: tuple[float, ...] = ()


@dataclass(frozen=True)
class Lattice:
    """Particles on a cubic lattice: a block, a block with a round hole, a ball or a disc."""

    shape: str
    spacing: float  # m
    origin: Vector  # lower corner of a block, middle of a ball or disc, m
    counts: tuple[int, int, int]  # of a block; (n, n, n) cells of the radius of a ball or disc
    hole: Vector = (0.0, 0.0, 0.0)  # middle (x, y) and radius of a hole along z, m


@dataclass(frozen=True)
class DeckBody:
    """Particles of one material in one component."""

    component: int
    material: int
    line: int
    lattice: Lattice | None = None
    mass: float = 0.0  # of a particle of the lattice, kg
    rows: tuple[ParticleRow, ...] = ()  # of each particle, without a lattice
    count: int = 0
    first: int = 1  # number in the deck of the first particle of the lattice


@dataclass(frozen=True)
class DeckVelocity:
    """An initial velocity (m/s) of a component, of a body or of one particle, by number from 1."""

    of: str
    number: int
    velocity: Vector
    line: int


@dataclass(frozen=True)
class DeckGravity:
    """The acceleration (m/s2) of a body, by number from 1."""

    body: int
    acceleration: Vector
    line: int


@dataclass(frozen=True, kw_only=True)
class Deck:
    """A deck as it was understood; SI."""

    title: str
    units: Units
    lower: Vector  # m
    cells: tuple[int, int, int]
    cell: float  # m
    faces: tuple[int, int, int, int, int, int]  # x0 xn y0 yn z0 zn: 0 free, 1 fixed, 2 symmetric
    materials: Mapping[int, DeckMaterial]
    bodies: tuple[DeckBody, ...]
    velocities: tuple[DeckVelocity, ...]
    detonations: tuple[Vector, ...]  # m
    gravity: Vector  # of all bodies, m/s2
    end_time: float  # s
    dt: float | None  # s
    step_scale: float  # of cell over sound speed, where dt is absent
    output_interval: float | None  # s
    scheme: SchemeName
    shape: str
    contact: bool
    jaumann: bool
    friction: float
    viscosity: tuple[float, float]  # quadratic, linear
    per_cell: int | None  # particles
    unused: tuple[str, ...]  # macros without effect here, with their lines

    @property
    def nodes(self) -> int:
        """Of the grid."""
        return math.prod(count + 1 for count in self.cells)

    @property
    def particles(self) -> int:
        """Of all bodies."""
        return sum(body.count for body in self.bodies)


@dataclass
class DeckState:
    """Everything that macros have set so far."""

    title: str = ""
    counts: dict[str, tuple[int, int]] = field(default_factory=dict)  # value and line, by macro
    numbers: dict[str, tuple[float, ...]] = field(default_factory=dict)
    switches: dict[str, bool] = field(default_factory=dict)
    materials: dict[int, DeckMaterial] = field(default_factory=dict)
    bodies: list[DeckBody] = field(default_factory=list)
    velocities: list[DeckVelocity] = field(default_factory=list)
    detonations: list[Vector] = field(default_factory=list)
    gravity: list[DeckGravity] = field(default_factory=list)
    faces: list[int] = field(default_factory=lambda: [0] * 6)
    shape: str = "linear"
    friction: float = 0.0
    read: int = 0  # particles
    unused: list[str] = field(default_factory=list)


def refuse_line(line: int, value: str, limit: str, cure: str) -> NoReturn:
    """Raise the error of a line of a deck."""
    raise InvalidInput([Finding(f"deck line {line}", value, limit, cure)])
