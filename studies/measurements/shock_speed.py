"""The speed of the shock in a plate."""

from studies.measurements import History, Measurement, Reading
from studies.measurements._plates import PLATES, speed_from


def _of(name: str) -> Measurement:
    front = f"{name}_shock_front"

    def read(history: History) -> Reading:
        return speed_from(history, front)

    return Measurement(
        name=f"{name}_shock_speed",
        title=f"Shock speed in the {name}",
        unit="m s-1",
        meaning=f"speed of the shock relative to the undisturbed {name}: slope of the front's path in the later half "
        "of the time",
        version=1,
        read=read,
        follows=(front,),
    )


MEASUREMENT = tuple(_of(name) for name in PLATES)
