"""How far the shock has run in the plate at rest."""

from studies.measurements import Measurement, Reading
from studies.measurements._plates import TARGET, PlateView, front_in_matter


def _read(seen: PlateView) -> Reading:
    return front_in_matter(seen, TARGET)


MEASUREMENT = Measurement(
    name="target_shock_front",
    title="Shock front in the target",
    unit="m",
    meaning="distance of the shock front, where the pressure falls to half, from the impact face of the undisturbed "
    "target",
    version=1,
    read=_read,
)
