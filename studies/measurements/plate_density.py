"""The density that particles of a plate carry behind the shock."""

from studies.measurements import Measurement, Reading
from studies.measurements._plates import PLATES, PlateView, plateau_mean


def _of(name: str, plate: int) -> Measurement:
    def read(view: PlateView) -> Reading:
        return plateau_mean(view, view.density, (plate,))

    return Measurement(
        name=f"{name}_density",
        title=f"Density in the {name}",
        unit="kg m-3",
        meaning=f"volume-weighted mean of the density that particles carry on the plateau of the {name}",
        version=1,
        read=read,
    )


MEASUREMENT = tuple(_of(name, plate) for name, plate in PLATES.items())
