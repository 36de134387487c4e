"""The distance that the shock has run in a plate."""

from studies.measurements import Measurement, Reading
from studies.measurements._plates import PLATES, PlateView, front_in_matter


def _of(name: str, plate: int) -> Measurement:
    def read(view: PlateView) -> Reading:
        return front_in_matter(view, plate)

    return Measurement(
        name=f"{name}_shock_front",
        title=f"Shock front in the {name}",
        unit="m",
        meaning="distance of the shock front, where the pressure falls to half, from the impact face of the "
        f"undisturbed {name}",
        version=1,
        read=read,
    )


MEASUREMENT = tuple(_of(name, plate) for name, plate in PLATES.items())
