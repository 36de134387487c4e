"""A run of a shield by stages: what a stage is about, and what those before it have left."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from studies.debris.setting import CloudSetting

if TYPE_CHECKING:
    from studies.debris.cloud import CloudView
    from studies.measurements.impact.view import ImpactView


@dataclass(frozen=True)
class ShieldSetting(CloudSetting):
    """A stage of a shield: the impact on the first bumper, or that of debris on the next sheet."""

    slowest: float  # speed below which matter does not come to the next sheet before its stage ends, m/s
    momentum: float  # momentum of the projectile along the normal of the sheets, N s (per radian in axisymmetry)
    bumpers: int = 1  # of the shield
    before: "tuple[BumperStage, ...]" = ()  # the stages of the bumpers in front


@dataclass(frozen=True)
class BumperStage:
    """The end of a bumper's stage, and the flight from there; masses in kg (per radian in axisymmetry)."""

    bumper: "ImpactView"
    cloud: "CloudView"
    mass: float  # of the bodies that were not there before
    coming: float  # mass that flies to the next grid
    missed: float  # mass that flies past it
    attached: float  # part of what would fly to it that has not come off this bumper, or not come to it
    clock_ahead: float  # s
    angular_momentum_error: float  # of the flight, relative
    piece: float | None  # diameter than which half of the mass of its pieces is in smaller ones, m; None without any
