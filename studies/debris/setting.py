"""What measurements of debris need to know of a set-up: how its matter melts and breaks."""

from dataclasses import dataclass

from studies.debris.breakup import Breakup
from studies.measurements._settings import ImpactSetting


@dataclass(frozen=True)
class Melting:
    """Residual energies of matter that say how much of it is molten at no pressure."""

    onset: float  # J/kg with which it begins to melt
    heat: float  # J/kg that it takes up from there until all of it is liquid


@dataclass(frozen=True)
class CloudSetting(ImpactSetting):
    """An impact whose debris is measured."""

    breakup: tuple[Breakup, ...]  # of each body
    melting: tuple[Melting | str, ...]  # of each body, or the flag that says why it has none
