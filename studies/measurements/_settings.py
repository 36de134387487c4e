"""What the measurements of a family need to know of a set-up: the problem that was built, and its sizes and speeds."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from solver.problem import Problem


@dataclass(frozen=True)
class Setting:
    """A problem; each family of scenarios adds what its view of a state needs to know."""

    problem: "Problem"
    sector: float  # angle that the model covers about its axis, rad; 1 in axisymmetry, where all is per radian
    # The measurements whose growth this stage waits for; None: all that the scenario names.
    settles: tuple[str, ...] | None = field(default=None, kw_only=True)


@dataclass(frozen=True)
class ImpactSetting(Setting):
    """An impact on a target."""

    target: str  # name of the body that is measured
    projectile_diameter: float  # m
    thickness: float  # of the target along the line of flight, m
    radius: float  # of the target, m: half its width where it is square
    speed: float  # of the projectile, m/s
