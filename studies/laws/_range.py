"""The range of a law: limits, each with words, its source, and a check where one is possible."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from studies.laws._shot import Shot

# In place of the source of a limit that none states. Such a limit is what is commonly quoted: it marks, and says so.
NOT_FOUND = "source not found"
# How the words of a range begin where no limit is one that the law's source states: reports read it in cubes.
NO_RANGE = "no range stated by its source"
# Sources of limits that follow from the equation or from what it is about, and that no source states as a range.
DERIVED = ("computed from", "the law is about", "the equation is about", "the definition of")

ROUND_OFF = 1e-9  # relative: a speed of exactly the limit, reached through a unit conversion, is inside


@dataclass(frozen=True)
class Limit:
    """One limit of a law's range."""

    words: str  # "like on like"
    source: str  # where the limit is stated, or NOT_FOUND
    outside: Callable[[Shot], str] | None = field(default=None, repr=False)  # the reason, or ""

    @property
    def is_published(self) -> bool:
        """Whether a source states this limit."""
        return self.source != NOT_FOUND and not self.source.startswith(DERIVED)

    @property
    def machine_checked(self) -> bool:
        """Whether a shot is checked against this limit, or only the reader is told."""
        return self.outside is not None

    def reason(self, shot: Shot) -> str:
        """Why a shot lies outside, with the source of the limit; empty inside, and where nothing is checked."""
        reason = self.outside(shot) if self.outside else ""
        return f"{reason} ({self.source})" if reason else ""


class Range:
    """The range of validity of a law: its own limits, and that of its projectiles."""

    def __init__(self, *limits: Limit, projectile: Limit | None = None):
        self.limits = limits
        # Rods and discs penetrate otherwise than spheres; round numbers, which no law here states.
        self.every = (*limits, projectile or length_ratio(0.5, 2.0, NOT_FOUND))

    @property
    def words(self) -> str:
        """All limits as one text, after the words that no source states any, where none does."""
        limits = "; ".join(_words(limit) for limit in self.every)
        return limits if self.is_published else f"{NO_RANGE}: {limits}"

    @property
    def is_published(self) -> bool:
        """Whether a source states any of the limits."""
        return any(limit.is_published for limit in self.every)

    def reasons(self, shot: Shot) -> list[str]:
        """Why a shot lies outside; empty inside."""
        reasons = (limit.reason(shot) for limit in self.every)
        return [reason for reason in reasons if reason]

    def describe(self) -> list[dict[str, Any]]:
        """The limits as plain values, for a catalogue."""
        return [
            {"words": limit.words, "source": limit.source, "machine_checked": limit.machine_checked}
            for limit in self.every
        ]


def like_on_like(source: str) -> Limit:
    """Projectile and target of the same family of materials."""

    def outside(shot: Shot) -> str:
        projectile, target = shot.projectile.family, shot.target.family
        return "" if projectile == target else f"{projectile} on {target} is not like on like"

    return Limit("like on like", source, outside)


# How the reason begins where a law is for another material than the target's: reports read it in cubes.
OTHER_MATERIAL = "calibrated on "


def family(name: str, source: str) -> Limit:
    """A target of one family of materials."""

    def outside(shot: Shot) -> str:
        family = shot.target.family
        return "" if family == name else f"{OTHER_MATERIAL}{name}, the target is {family}"

    return Limit(f"{name} target", source, outside)


def speed(minimum: float, maximum: float, source: str) -> Limit:
    """Impact speed in km/s."""
    return between("v", lambda shot: shot.speed / 1e3, (minimum, maximum), "km/s", source)


def thickness_ratio(minimum: float, maximum: float, source: str) -> Limit:
    """Plate thickness over projectile diameter."""
    return between("t/d", lambda shot: shot.thickness_ratio, (minimum, maximum), "", source)


def length_ratio(minimum: float, maximum: float, source: str) -> Limit:
    """Length of the projectile over its diameter."""
    bounds = (minimum, maximum)
    return between("projectile L/d", lambda shot: shot.length_ratio, bounds, "", source)


def between(symbol: str, of: Callable[[Shot], float], bounds: tuple[float, float], unit: str, source: str) -> Limit:
    """A number of the shot between two bounds, inclusive; an infinite bound is none."""
    low, high = bounds
    unit = f" {unit}" if unit else ""

    def outside(shot: Shot) -> str:
        value = of(shot)
        if value < low * (1.0 - ROUND_OFF):
            return f"{symbol} = {value:.3g}{unit} is below {low:g}{unit}"
        if value > high * (1.0 + ROUND_OFF):
            return f"{symbol} = {value:.3g}{unit} is above {high:g}{unit}"
        return "" if math.isfinite(value) else f"{symbol} is not defined for this shot"

    return Limit(_interval(symbol, low, high, unit), source, outside)


def plate() -> Limit:
    """A target with a back face."""

    def outside(shot: Shot) -> str:
        return "" if shot.plate_thickness else "t/d is not defined for this shot"

    return Limit("a plate with a back face", "the law is about holes", outside)


def density_ratio(minimum: float, maximum: float, source: str) -> Limit:
    """Density of the projectile over that of the target."""
    bounds = (minimum, maximum)
    return between("rho_p/rho_t", lambda shot: shot.density_ratio, bounds, "", source)


def _interval(symbol: str, low: float, high: float, unit: str) -> str:
    below = f"{low:.3g} <= " if low > 0.0 else ""
    above = f" <= {high:.3g}" if math.isfinite(high) else ""
    if above:
        return f"{below}{symbol}{above}{unit}"
    return f"{symbol} >= {low:g}{unit}"


def _words(limit: Limit) -> str:
    checked = "checked" if limit.machine_checked else "not checked"
    return f"{limit.words} ({limit.source}; {checked})"
