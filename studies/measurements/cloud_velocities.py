"""How fast the front and the rear of a debris cloud fly."""

from collections.abc import Callable

from studies.measurements import Measurement, Reading
from studies.measurements._cloud import CloudView, exceeded_reading

PERCENT, PERMILLE = 0.01, 0.001


def _faster(share: float) -> Callable[[CloudView], Reading]:
    def read(view: CloudView) -> Reading:
        return exceeded_reading(view, view.axial_velocity, share, view.behind())

    return read


def _rear(view: CloudView) -> Reading:
    """Of the projectile alone, which makes the rear of a cloud: behind it comes the lip of the hole, which stays."""
    among = view.behind() & view.projectile
    return exceeded_reading(view, view.axial_velocity, 1.0 - PERCENT, among)


def _velocity(name: str, title: str, share: str, whose: str, read: Callable[[CloudView], Reading]) -> Measurement:
    return Measurement(
        name=name,
        title=title,
        unit="m s-1",
        meaning=f"axial velocity that {share} of the mass of {whose} behind the plate exceeds; few particles where one "
        "of them has more than the share",
        version=1,
        read=read,
    )


MEASUREMENT = (
    _velocity("tip_velocity_percent", "Tip velocity (1 %)", "1 %", "all matter", _faster(PERCENT)),
    _velocity("tip_velocity_permille", "Tip velocity (0.1 %)", "0.1 %", "all matter", _faster(PERMILLE)),
    _velocity("rear_velocity", "Rear velocity", "99 %", "the projectile", _rear),
)
