"""What the measurements of a family need to know of a set-up: the problem that was built, and its sizes and speeds."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from studies.measurements._breakup import Breakup

if TYPE_CHECKING:
    import numpy as np

    from solver.problem import Problem


@dataclass(frozen=True)
class Setting:
    """A problem; each family of scenarios adds what its view of a state needs to know."""

    problem: "Problem"
    sector: float  # angle that the model covers about its axis, rad; 1 in axisymmetry, where all is per radian
    # The measurements whose growth this stage waits for; None: all that the scenario names.
    settles: tuple[str, ...] | None = field(default=None, kw_only=True)


# Length, mushroom diameter and width of a bar to be compared with, m.
References = tuple[float | None, float | None, float | None]


@dataclass(frozen=True, kw_only=True)
class BarSetting(Setting):
    """A bar at a wall."""

    length: float  # m
    speed: float  # m/s
    place: "np.ndarray"  # (n, 3) of each particle in the initial lattice: across, across, along
    references: References


@dataclass(frozen=True, kw_only=True)
class PlateSetting(Setting):
    """Two plates, a flyer and a target."""

    speed: float  # m/s
    thicknesses: tuple[float, float]  # flyer, target; m
    section: float  # area of the column, m2 (m2 per radian)
    impedance: float  # rho0 c0 of the target, Pa s/m
    crossing: float  # when the first wave has crossed its plate, s
    layer: "np.ndarray"  # (n,) of each particle, counted from the interface


@dataclass(frozen=True)
class ImpactSetting(Setting):
    """An impact on a target."""

    target: str  # name of the body that is measured
    projectile_diameter: float  # m
    thickness: float  # of the target along the line of flight, m
    radius: float  # of the target, m: half its width where it is square
    speed: float  # of the projectile, m/s


@dataclass(frozen=True)
class Melting:
    """Constants with which the residual energy of matter says how much of it is molten at no pressure."""

    heat_capacity: float  # J/(kg K)
    room_temperature: float  # K
    melt_temperature: float  # K
    latent_heat: float  # J/kg


@dataclass(frozen=True)
class CloudSetting(ImpactSetting):
    """An impact whose debris is measured."""

    breakup: tuple[Breakup, ...]  # of each body
    melting: tuple[Melting | str, ...]  # of each body, or the flag that says why it has none
