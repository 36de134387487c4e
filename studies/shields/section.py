"""The section of the ballistic limit: at each speed, on each shield, what holds, what perforates, and what is likely.

The interval of the simulation reaches from the largest projectile whose wall holds to the smallest that perforates it.
Diameters are those of the sphere with the projectile's volume, as the equations have them.
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING

from studies.laws import Shot
from studies.outcomes.found import FailuresFound, Share, Shares
from studies.reports.records import Outcome, Place
from studies.reports.section import Part, Section, Source
from studies.shields.shield import WALL_PERFORATED, ShotAtShield
from studies.shields.shots.records import Probability, SafeSize
from studies.shields.shots.table import NearShot
from studies.sweeps.search import Chance, Guide

if TYPE_CHECKING:
    import xarray as xr


class Incomparable(StrEnum):
    """Why an equation is not comparable with the simulation."""

    OUTSIDE = "outside"  # of the equation's range
    FLAGGED = "flagged"  # the runs at the ends of the interval are
    DEFINITIONS = "definitions"  # runs were measured by several
    ONE_END = "one_end"  # the interval has one end, which does not contradict the equation
    NO_END = "no_end"


@dataclass(frozen=True)
class WallRun:
    """What the projectile of a point did to the wall, and how likely the wall fails."""

    diameter: float  # m
    perforated: bool | None  # None: undecided
    says: bool | None  # what its grid says where flags leave that open
    state: str  # of the run
    grids: str  # what its grids say together; empty of one grid
    flags: tuple[str, ...]
    doubts: tuple[str, ...]  # the flags that leave it open
    probability: Probability | None = None  # from equations and shots
    outside: str = ""  # why the shot is like none of the published ones
    cannot_tell: bool = False  # it holds near its limit, where simulations like it miss most failures


@dataclass(frozen=True)
class Equation:
    """What an equation says beside the interval of the simulation."""

    law: str  # label
    title: str
    name: str  # short
    diameter: float  # m, the critical one
    outcome: Outcome  # high: unsafe, it says that a wall holds which is perforated; low: too careful
    difference: float | None  # beyond the interval, over the nearer end; None where it is not comparable
    reason: Incomparable | None
    outside: str  # why it is outside of its range


@dataclass(frozen=True)
class ShieldLimit:
    """Simulation and equations at one speed, on one shield."""

    at: Place  # values of the axes beside speed and diameter
    speed: float  # m/s
    normal_speed: float  # m/s
    runs: tuple[WallRun, ...]  # by ascending diameter
    lower: float | None  # m: the largest that holds
    upper: float | None  # m: the smallest that perforates
    reason: Incomparable | None  # why no equation is judged
    flags: tuple[str, ...]  # of the runs at the ends
    equations: tuple[Equation, ...]  # nearest first
    found: Share | None  # of perforated walls: those that such simulations perforate; None where none was simulated


@dataclass(frozen=True)
class OrderedShots:
    """Published shots that are easier than one in every respect, or harder."""

    shots: int
    contrary: int  # of these: easier and failed, or harder and held


@dataclass(frozen=True)
class Beside:
    """Published shots beside the shot that opens the report, and the designer's inverse of it."""

    at: Place
    speed: float
    diameter: float
    failed: int  # of the shots on shields like it, at any speed and of any diameter
    held: int
    easier: OrderedShots
    harder: OrderedShots
    nearest: tuple[NearShot, ...]
    safe: tuple[SafeSize, ...]


@dataclass(frozen=True)
class BallisticLimit:
    """The limits of a sweep of shields."""

    rows: tuple[ShieldLimit, ...]
    beside: Beside | None
    has_grids: bool  # whether each point has several


def _part(source: Source) -> Part | None:
    from studies.shields.part import part_of

    return part_of(source)


SECTION = Section(
    "ballistic_limit",
    "Ballistic limit",
    10,
    BallisticLimit,
    _part,
    "studies.shields:section.html",
    "studies.shields:first.html",
    "studies.shields:appendix.html",
    rank=10,
)


def _found_at(points: "xr.Dataset") -> Shares | None:
    from studies.shields.limit import failures_found_at

    return failures_found_at(points)


def _chance(shot: Shot) -> Chance | None:
    from studies.shields.shots.chance import chance_of_diameter

    return chance_of_diameter(shot) if isinstance(shot, ShotAtShield) else None


GUIDE = Guide(
    "shields",
    WALL_PERFORATED,
    "projectile_diameter",
    _chance,
    doubt="simulations miss walls that were perforated, so that it is too large rather than too small; equations and "
    "published shots decide (docs/does-my-shield-hold.md)",
)
FOUND = FailuresFound(WALL_PERFORATED, _found_at)
