"""Velocity and stress on the axis halfway along a bar, and the largest of each: what a wave does that passes."""

import math

import numpy as np

from studies.measurements import History, Measurement, Reading
from studies.measurements._bar import BarView, middle_of

VELOCITY, STRESS = "middle_velocity", "middle_stress"
WHERE = "of the matter beside the axis that stood halfway along the bar"


def _velocity(view: BarView) -> Reading:
    return middle_of(view, view.velocity[:, 2])


def _stress(view: BarView) -> Reading:
    return middle_of(view, view.stress)


def _peak_velocity(history: History) -> Reading:
    return _peak(history.values[VELOCITY])


def _peak_stress(history: History) -> Reading:
    return _peak(history.values[STRESS])


def _peak(values: np.ndarray) -> Reading:
    """The reading of largest magnitude, with its sign; uncertain by its distance to the readings beside it."""
    if np.isnan(values).any():
        return Reading(math.nan, flags=("lost_particles",))
    at = int(np.abs(values).argmax())
    beside = values[max(at - 1, 0) : at + 2]
    return Reading(float(values[at]), {"sampling": float(np.ptp(beside))})


MEASUREMENT = (
    Measurement(
        name=VELOCITY,
        title="Velocity in the middle",
        unit="m s-1",
        meaning=f"axial velocity, away from the wall, {WHERE}",
        version=1,
        read=_velocity,
    ),
    Measurement(
        name=STRESS,
        title="Stress in the middle",
        unit="Pa",
        meaning=f"axial stress, negative in compression and without artificial viscosity, {WHERE}",
        version=1,
        read=_stress,
    ),
    Measurement(
        name="middle_peak_velocity",
        title="Peak velocity in the middle",
        unit="m s-1",
        meaning=f"largest axial velocity so far, with its sign, {WHERE}",
        version=1,
        read=_peak_velocity,
        follows=(VELOCITY,),
    ),
    Measurement(
        name="middle_peak_stress",
        title="Peak stress in the middle",
        unit="Pa",
        meaning=f"largest axial stress so far, with its sign, {WHERE}",
        version=1,
        read=_peak_stress,
        follows=(STRESS,),
    ),
)
