"""The momentum of a bar away from the wall, over its initial momentum."""

from studies.measurements import Measurement, Reading
from studies.measurements._bar import LOADED, BarView


def _read(view: BarView) -> Reading:
    if view.is_loaded:
        return LOADED
    momentum = float((view.mass * view.velocity[:, 2]).sum())
    initial = float(view.mass.sum()) * view.speed
    return Reading(momentum / initial, {"resolution": view.share})


MEASUREMENT = Measurement(
    name="rebound_momentum",
    title="Momentum after the rebound",
    unit="1",
    meaning="axial momentum away from the wall over the initial one towards it: -1 before, 1 after a perfect rebound",
    version=1,
    read=_read,
)
