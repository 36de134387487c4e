"""How much of the target is still in one piece."""

from studies.measurements import Measurement, Reading


def _read(seen):
    return Reading(float(seen.mass[seen.attached_target].sum()) / seen.target_mass)


MEASUREMENT = Measurement(
    name="attached_share",
    title="Attached share",
    unit="1",
    meaning="mass connected to the target over that of the whole target",
    definition=_read,
)
