"""Where the initial kinetic energy of a bar has gone: rigid motion, vibration, strain, losses."""

from collections.abc import Callable

from studies.measurements import Measurement, Reading
from studies.measurements._bar import LOADED, BarView, Energies, energies


def _share(name: str, title: str, meaning: str, of: Callable[[Energies], float]) -> Measurement:
    def read(view: BarView) -> Reading:
        return LOADED if view.is_loaded else Reading(of(energies(view)), {"resolution": view.share})

    return Measurement(name=name, title=title, unit="1", meaning=meaning, version=1, read=read)


MEASUREMENT = (
    _share(
        "rigid_energy",
        "Energy of rigid motion",
        "kinetic energy of the bar's motion as a whole along its axis, over the initial kinetic energy",
        lambda split: split.rigid,
    ),
    _share(
        "vibration_energy",
        "Energy of vibration",
        "kinetic energy of the bar's parts against its centre of mass, over the initial kinetic energy",
        lambda split: split.vibration,
    ),
    _share(
        "strain_energy",
        "Energy of strain",
        "elastic energy over the initial kinetic one; per mass K (ln r - 1 + 1/r) / rho0 + s:s / 4 G rho with "
        "r = rho / rho0",
        lambda split: split.strain,
    ),
    # Heat of viscosity and plastic work, the energy that the wall took, and the drift, which the audit has alone.
    _share(
        "lost_energy",
        "Energy lost",
        "initial kinetic energy that is neither motion nor elastic strain any more, over itself",
        lambda split: 1.0 - split.rigid - split.vibration - split.strain,
    ),
)
