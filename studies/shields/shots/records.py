"""What is said of a shot at a shield: how likely it fails, and the sizes at which it is just safe."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum

from solver.units import Metre


@dataclass(frozen=True)
class Probability:
    """A probability with the interval, at 95 %, that a laboratory not seen may find."""

    value: float
    low: float
    high: float


class Size(StrEnum):
    """A size of a shot that is looked for, by the name of its parameter."""

    SPHERE = "projectile_diameter"  # the largest
    WALL = "wall_thickness"  # the thinnest
    STAND_OFF = "stand_off"  # the shortest


class NoSize(StrEnum):
    """Why there is no largest sphere, thinnest wall or shortest stand-off."""

    SAFE = "safe_throughout"  # the shield is safe at every size that may be asked
    UNSAFE = "unsafe_throughout"  # it is safe at none
    OUTSIDE_OF_SHOTS = "outside_of_shots"  # the shot is like none of the published ones in something else
    NO_EQUATION = "no_equation"  # the equation does not cover the shot, or for a risk none does


@dataclass(frozen=True)
class SafeSize:
    """The size at which a shield is just safe, all else as in the shot."""

    size: Size
    risk: float | None  # probability to fail; None of an equation
    law: str | None  # name of an equation; None of a risk
    value: Metre | None  # None with a reason
    reason: NoSize | None = None


def written(entries: Mapping[str, object]) -> str:
    """What is stored of equations or simulations by name: JSON, a line each."""
    lines = (f" {json.dumps(name)}: {json.dumps(entry)}" for name, entry in entries.items())
    return "{\n" + ",\n".join(lines) + "\n}\n"
