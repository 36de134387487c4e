"""How far the shock has run in the flying plate."""

from studies.measurements import Measurement, Reading
from studies.measurements._plates import FLYER, PlateView, front_in_matter


def _read(seen: PlateView) -> Reading:
    return front_in_matter(seen, FLYER)


MEASUREMENT = Measurement(
    name="flyer_shock_front",
    title="Shock front in the flyer",
    unit="m",
    meaning="distance of the shock front, where the pressure falls to half, from the impact face of the undisturbed "
    "flyer",
    version=1,
    read=_read,
)
