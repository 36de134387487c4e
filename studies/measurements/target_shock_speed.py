"""How fast the shock runs in the plate at rest."""

from studies.measurements import History, Measurement, Reading
from studies.measurements._plates import speed_from

FRONT = "target_shock_front"


def _read(history: History) -> Reading:
    return speed_from(history, FRONT)


MEASUREMENT = Measurement(
    name="target_shock_speed",
    title="Shock speed in the target",
    unit="m s-1",
    meaning="speed of the shock relative to the undisturbed target: slope of the front's path in the later half of the "
    "time",
    version=1,
    read=_read,
    follows=(FRONT,),
)
