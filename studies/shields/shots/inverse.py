"""The designer's inverse: the largest sphere, the thinnest wall and the shortest stand-off that are still safe.

Each is by a risk to fail (``probability``) or by an equation, all else as in the shot. A risk is asked where the
published shots are, an equation wherever it has a value.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache, partial

from solver.units import Metre
from studies import laws
from studies.laws import Law
from studies.shields.roots import root_between
from studies.shields.shield import CRITICAL_DIAMETER, ShotAtShield, reshielded
from studies.shields.shots.chance import chance_of, chance_of_diameter
from studies.shields.shots.judged import margin
from studies.shields.shots.outside import bounds_of_shots, outside_of_shots
from studies.shields.shots.records import NoSize, SafeSize, Size

RISKS = (0.1, 0.5)
WITHIN = 1e-5  # relative, of a size: the risk changes by less than 0.01 % of it
# Of equations, which state no bounds of walls and stand-offs: what a question to laws may have.
OF_EQUATIONS: Mapping[str, tuple[Metre, Metre]] = {"wall_thickness": (1e-6, 1.0), "stand_off": (1e-6, 10.0)}


def safe_sizes(shot: ShotAtShield) -> tuple[SafeSize, ...]:
    """Every size by every risk, then by every equation."""
    asked = (law for law in laws.answering(CRITICAL_DIAMETER) if not law.meaningless(shot, ""))
    return (*_by_risk(shot), *(size for law in asked for size in _by_equation(law, shot)))


def resized(shot: ShotAtShield, size: Size, value: Metre) -> ShotAtShield:
    """The shot with another sphere, wall or stand-off."""
    if size is Size.SPHERE:
        return replace(shot, projectile_diameter=value)
    return reshielded(shot, **{size.value: value})


def _by_risk(shot: ShotAtShield) -> Iterator[SafeSize]:
    for size in Size:
        low, high = bounds_of_shots(shot)[size]
        inside = low < high and not any(outside_of_shots(resized(shot, size, math.sqrt(low * high))))
        chance = _chance(shot, size) if inside else None
        for risk in RISKS:
            if chance is None:
                yield SafeSize(size, risk, None, None, NoSize.NO_EQUATION if inside else NoSize.OUTSIDE_OF_SHOTS)
            else:
                yield SafeSize(size, risk, None, *_just_safe(size, chance, low, high, limit=risk))


def _chance(shot: ShotAtShield, size: Size) -> Callable[[float], float] | None:
    """The probability to fail as a function of a size; None where no equation covers the shot."""
    if size is Size.SPHERE:
        return chance_of_diameter(shot)
    chance = chance_of(shot)
    return cache(lambda value: chance(resized(shot, size, value))) if chance else None


def _by_equation(law: Law, shot: ShotAtShield) -> Iterator[SafeSize]:
    covers = not math.isnan(margin(law, shot))

    def margin_at(size: Size, value: float) -> float:
        return margin(law, resized(shot, size, value))

    for size in Size:
        if not covers:
            yield SafeSize(size, None, law.name, None, NoSize.NO_EQUATION)
        elif size is Size.SPHERE:
            yield SafeSize(size, None, law.name, law.evaluate(shot).value)
        else:
            yield SafeSize(size, None, law.name, *_just_safe(size, partial(margin_at, size), *OF_EQUATIONS[size]))


def _just_safe(
    size: Size, function: Callable[[float], float], low: Metre, high: Metre, limit: float = 0.0
) -> tuple[Metre | None, NoSize | None]:
    """The size between two bounds beyond which a function of it exceeds a limit, on the safe side; or why none does."""

    def excess(value: float) -> float:
        return function(value) - limit

    unsafe = [excess(end) > 0.0 for end in (low, high)]
    if all(unsafe) or not any(unsafe):
        return None, NoSize.UNSAFE if all(unsafe) else NoSize.SAFE
    found = root_between(lambda x: excess(math.exp(x)), math.log(low), math.log(high), within=WITHIN)
    # Where an equation jumps, as one does at S/d = 30, the root may lie on its other side.
    safer = -WITHIN if size is Size.SPHERE else WITHIN
    return math.exp(found if excess(math.exp(found)) <= 0.0 else found + safer), None
