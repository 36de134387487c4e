"""The density that the distances of particles in a plate give behind the shock."""

from studies.measurements import Measurement, Reading
from studies.measurements._plates import PLATES, PlateView, density_from_spacing


def _of(name: str, plate: int) -> Measurement:
    def read(view: PlateView) -> Reading:
        return density_from_spacing(view, plate)

    return Measurement(
        name=f"{name}_density_from_spacing",
        title=f"Density in the {name} from spacing",
        unit="kg m-3",
        meaning=f"mass between the outermost layers of the plateau of the {name}, over the volume between them: what "
        "the positions of particles say, not what they carry",
        version=1,
        read=read,
    )


MEASUREMENT = tuple(_of(name, plate) for name, plate in PLATES.items())
