"""What measurements of debris need to know of a set-up: how its matter melts and breaks."""

from dataclasses import dataclass

from studies.debris.breakup import Breakup
from studies.measurements._settings import ImpactSetting


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
