"""The range of a law as records: its limits, and the reasons why a shot is outside; ``_words`` puts them into words."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from types import MappingProxyType
from typing import Self

from studies.laws._shot import Shot

# In place of the source of a limit that none states. Such a limit is what is commonly quoted: it marks, and says so.
NOT_FOUND = "source not found"
ROUND_OFF = 1e-9  # relative: a speed of exactly the limit, reached through a unit conversion, is inside
SPEED, THICKNESS_RATIO = "v", "t/d"  # symbols of numbers between bounds


class RangeCode(StrEnum):
    """A kind of limits and of reasons, with their words; features add members in enumerations of their own."""

    limit: str  # words of a limit; empty where there is none of the kind
    reason: str  # words of the reason why a shot is outside, or the law has no answer
    is_other_material: bool  # whether the law is for another material than a target's

    def __new__(cls, value: str, limit: str = "", reason: str = "", is_other_material: bool = False) -> Self:
        """A member: its value, and its words as format strings (``_words``)."""
        member = str.__new__(cls, value)
        member._value_, member.limit, member.reason = value, limit, reason
        member.is_other_material = is_other_material
        return member


class Code(RangeCode):
    """Kinds of limits, and of reasons why a law is outside of them or has no answer."""

    BETWEEN = "between"  # a number of the shot between two bounds, which has words of its own
    LIKE_ON_LIKE = (  # projectile and target of one family of materials
        "like_on_like",
        "like on like",
        "{found[projectile]} on {found[target]} is not like on like",
    )
    TARGET_FAMILY = "target_family", "{first} target", "calibrated on {first}, {others}", True
    MATERIALS = "materials", "{names}", "{found[projectile]} on {found[target]} is not {names}"  # those of a fit
    PLATE = "plate", "a plate with a back face", "the target is no plate with a back face"
    WIDER_THAN_PROJECTILE = (  # speeds at which the hole is wider than the projectile
        "wider_than_projectile",
        "{first}, where D/d >= 1",
        "{symbol} = {value:.3g}{unit} is below {low:.3g}{unit}, where D/d falls below 1",
    )
    STATED = "stated", "{first}"  # what a source says of its shots, which no shot is checked against
    # Of reasons alone.
    OBLIQUITY = "obliquity", "", "for {largest}, the shot is {value:.3g}{unit} oblique"
    NARROWER_THAN_PROJECTILE = (
        "narrower_than_projectile",
        "",
        "D/d = {value:.3g} is narrower than the projectile: no physical meaning for this shot",
    )
    NO_HARDNESS = "no_hardness", "", "the material {found[target]} states no Brinell hardness"
    NO_VARIANT = "no_variant", "", "{first} is not stated for this material"  # the constant of a variant
    NO_VALUE = "no_value", "", "the form has no value here"  # of a fit
    NO_SHOT = "no_shot", "", "this run does not describe one shot, or has not ended"
    FITTED = "fitted", "", "a constant of the law is fitted to this shot"


class RangeStatus(StrEnum):
    """How an answer stands to the range of its law."""

    INSIDE = "inside"
    OUTSIDE_RANGE = "outside_range"
    OTHER_MATERIAL = "other_material"  # the law is for another material than that of the target, or a part of it
    NO_ANSWER = "no_answer"
    FITTED = "fitted"


@dataclass(frozen=True)
class Reason:
    """Why a shot is outside of a limit, or a law has no answer for it."""

    code: RangeCode
    symbol: str = ""  # of the number that is outside: "v"
    value: float = math.nan  # of the shot, in ``unit``; NaN where it is not defined
    low: float = -math.inf
    high: float = math.inf
    unit: str = "1"  # SI
    names: tuple[str, ...] = ()  # of the limit: families or materials
    found: Mapping[str, str] = field(default_factory=dict)  # what the shot has instead, by role
    source: str = ""  # of the limit; empty where there is no answer


@dataclass(frozen=True)
class Limit:
    """One limit of a law's range."""

    code: RangeCode
    source: str  # where the limit is stated, or NOT_FOUND
    symbol: str = ""  # of a number between bounds
    low: float = -math.inf  # inclusive, in ``unit``; an infinite bound is none
    high: float = math.inf
    unit: str = "1"  # SI
    names: tuple[str, ...] = ()  # families or materials, or what the source says of its shots
    is_derived: bool = False  # from the equation or from what it is about: no source states it as a range
    check: Callable[["Limit", Shot], Reason | None] | None = field(default=None, repr=False)

    @property
    def is_published(self) -> bool:
        """Whether a source states this limit."""
        return self.source != NOT_FOUND and not self.is_derived

    @property
    def machine_checked(self) -> bool:
        """Whether a shot is checked against this limit, or only the reader is told."""
        return self.check is not None

    def reason(self, shot: Shot) -> Reason | None:
        """Why a shot lies outside, with the source of the limit; None inside, and where nothing is checked."""
        reason = self.check(self, shot) if self.check else None
        return reason and replace(reason, source=self.source)

    def broken(self, value: float = math.nan, found: Mapping[str, str] = MappingProxyType({})) -> Reason:
        """The reason of a shot that has another number, or something else by role."""
        return Reason(self.code, self.symbol, value, self.low, self.high, self.unit, self.names, found)


class Range:
    """The range of validity of a law: its own limits, and that of its projectiles."""

    def __init__(self, *limits: Limit, projectile: Limit | None = None):
        self.limits = limits
        # Rods and discs penetrate otherwise than spheres; round numbers, which no law here states.
        self.every = (*limits, projectile or length_ratio(0.5, 2.0, NOT_FOUND))

    @property
    def is_published(self) -> bool:
        """Whether a source states any of the limits."""
        return any(limit.is_published for limit in self.every)

    def bounds(self, symbol: str) -> tuple[float, float]:
        """The bounds, SI, that sources state of a number; NaN for one that none states."""
        mine = [limit for limit in self.limits if limit.symbol == symbol and limit.is_published]
        low = max((limit.low for limit in mine), default=math.nan)
        high = min((limit.high for limit in mine), default=math.nan)
        return low if math.isfinite(low) else math.nan, high if math.isfinite(high) else math.nan

    def reasons(self, shot: Shot) -> tuple[Reason, ...]:
        """Why a shot lies outside; empty inside."""
        return tuple(reason for limit in self.every if (reason := limit.reason(shot)))


def stated(text: str, source: str, *, is_derived: bool = False) -> Limit:
    """What a source says of its shots, for the reader alone."""
    return Limit(Code.STATED, source, names=(text,), is_derived=is_derived)


def like_on_like(source: str) -> Limit:
    """Projectile and target of the same family of materials."""

    def check(limit: Limit, shot: Shot) -> Reason | None:
        projectile, target = shot.projectile.family, shot.target.family
        return None if projectile == target else limit.broken(found={"projectile": projectile, "target": target})

    return Limit(Code.LIKE_ON_LIKE, source, check=check)


def family(name: str, source: str, *, is_derived: bool = False) -> Limit:
    """A target of one family of materials."""

    def check(limit: Limit, shot: Shot) -> Reason | None:
        return None if shot.target.family == name else limit.broken(found={"target": shot.target.family})

    return Limit(Code.TARGET_FAMILY, source, names=(name,), is_derived=is_derived, check=check)


def speed(minimum: float, maximum: float, source: str) -> Limit:
    """Impact speed in km/s."""
    return between(SPEED, lambda shot: shot.speed, (1e3 * minimum, 1e3 * maximum), source, "m s-1")


def thickness_ratio(minimum: float, maximum: float, source: str) -> Limit:
    """Plate thickness over projectile diameter."""
    return between(THICKNESS_RATIO, lambda shot: shot.thickness_ratio, (minimum, maximum), source)


def length_ratio(minimum: float, maximum: float, source: str) -> Limit:
    """Length of the projectile over its diameter."""
    return between("projectile L/d", lambda shot: shot.length_ratio, (minimum, maximum), source)


def density_ratio(minimum: float, maximum: float, source: str, *, is_derived: bool = False) -> Limit:
    """Density of the projectile over that of the target."""
    limit = between("rho_p/rho_t", lambda shot: shot.density_ratio, (minimum, maximum), source)
    return replace(limit, is_derived=is_derived)


def between(
    symbol: str, of: Callable[[Shot], float], bounds: tuple[float, float], source: str, unit: str = "1"
) -> Limit:
    """A number of the shot, SI, between two bounds, inclusive; an infinite bound is none."""

    def check(limit: Limit, shot: Shot) -> Reason | None:
        value = of(shot)
        inside = limit.low * (1.0 - ROUND_OFF) <= value <= limit.high * (1.0 + ROUND_OFF)
        return None if inside and math.isfinite(value) else limit.broken(value)

    return Limit(Code.BETWEEN, source, symbol, *bounds, unit, check=check)


def plate() -> Limit:
    """A target with a back face."""

    def check(limit: Limit, shot: Shot) -> Reason | None:
        return None if shot.plate_thickness else limit.broken()

    return Limit(Code.PLATE, "the law is about holes", is_derived=True, check=check)
