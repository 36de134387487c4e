"""Mean axial velocity of a plug."""

from studies.measurements import Measurement, Reading
from studies.measurements._plug import PlugView, mean_velocity, without_plug
from studies.values.results import DEFINITION

HALF = 0.5  # between two definitions: the part of the uncertainty


def _read(view: PlugView) -> Reading:
    if not view.has_plug:
        return without_plug()
    value = mean_velocity(view, view.plug)
    return Reading(value, {DEFINITION: HALF * abs(mean_velocity(view, view.core) - value)})


MEASUREMENT = Measurement(
    name="plug_velocity",
    title="Velocity of the plug",
    unit="m s-1",
    meaning="mass-weighted mean axial velocity of the plug, with the failed matter that flies with it",
    version=2,
    read=_read,
)
