"""Observer of impacts: particles about the line of flight, and the part of the target that has come loose."""

from typing import Any

from studies.scenarios import ImpactSetting, ObservationRate, ObserverOptions
from studies.scenarios._impact import settled_window

# A cross-check of connectivity, which alone decides what is plate: MPM3D-F90's holes were read from particles slower
# than this, m/s.
FAST = 300.0


def _rate(parameters: Any, setting: Any) -> ObservationRate:
    return ObservationRate.settling(parameters, settled_window(parameters))


def _view(setting: ImpactSetting, snapshot: Any) -> Any:
    from studies.measurements._impact import view

    return view(setting, snapshot)


def _numbers(view: Any) -> dict[str, float]:
    fast = view.attached_target & (view.speed > FAST)
    return {
        "separated_mass_fraction": 1.0 - _share(view, view.attached_target),
        "fast_mass_fraction": _share(view, fast),
    }


def _share(view: Any, keep: Any) -> float:
    """Mass of some particles over that of the whole target."""
    return float(view.mass[keep].sum()) / view.target_mass


IMPACT = ObserverOptions(
    rate=_rate,
    view=_view,
    numbers=_numbers,
    least_cells={"cells_per_diameter": 16.0, "cells_per_thickness": 4.0},
    # At 6 km/s a plate of a twentieth of the diameter has a hole of 16.4 mm with 0.8 cells through it, 11.3 with 2.4.
    fewest_cells={"cells_per_thickness": 2.0},
)
