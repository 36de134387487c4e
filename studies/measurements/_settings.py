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


@dataclass(frozen=True)
class Melting:
    """Constants with which the residual energy of matter says how much of it is molten at no pressure."""

    heat_capacity: float  # J/(kg K)
    room_temperature: float  # K
    melt_temperature: float  # K
    latent_heat: float  # J/kg


@dataclass(frozen=True)
class Breakup:
    """Constants with which a strain rate says how fine matter breaks; None where no source states one."""

    density: float  # kg/m3
    sound_speed: float  # m/s
    yield_stress: float | None  # Pa, of the first slip
    fracture_toughness: float | None  # Pa m^0.5
    surface_tension: float | None  # N/m


@dataclass(frozen=True)
class CloudSetting(ImpactSetting):
    """An impact whose debris is measured."""

    breakup: tuple[Breakup, ...]  # of each body
    melting: tuple[Melting | str, ...]  # of each body, or the flag that says why it has none
