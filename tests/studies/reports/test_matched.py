"""Matched observations: interpolation to a shot's parameters, and the error bar that it has."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr

from studies.cubes.points import SUCCEEDED
from studies.reports.matched import interpolate

FLAGS = {"flag_masks": [1, 2], "flag_meanings": "closed_on_axis near_rim"}
AXES = {"speed": (1.0, 2.0, 4.0), "plate_thickness": (1.0, 3.0, 4.0)}
CUBIC = (1.0, 2.0, 3.0, 4.0)  # x^3 there: f[2, 3, 1] = 6 and f[2, 3, 4] = 9


def grid(law: Callable[..., np.ndarray], bar: float = 0.0, /, **axes: tuple[float, ...]) -> xr.Dataset:
    """Runs over all combinations of axis values that measure exactly a law, each with an error bar."""
    value = law(*np.meshgrid(*axes.values(), indexing="ij"))
    dims = tuple(axes)
    return xr.Dataset(
        {
            "depth": (dims, value),
            "depth_reading_uncertainty": (dims, np.full(value.shape, bar)),
            "depth_converged_uncertainty_mesh": (dims, np.full(value.shape, bar)),
            "depth_flags": (dims, np.zeros(value.shape, np.int32), FLAGS),
            "run_state": (dims, np.full(value.shape, SUCCEEDED)),
        },
        coords={name: list(values) for name, values in axes.items()},
        attrs={"axes": " ".join(axes), "refinements": "", "measurement_versions": "{}"},
    )


def failed(dataset: xr.Dataset, **at: float) -> xr.Dataset:
    """The runs with one run failed."""
    dataset.run_state.loc[at] = SUCCEEDED + 1
    return dataset


def cubic(speed: np.ndarray) -> np.ndarray:
    return speed**3


def bowl(speed: np.ndarray, thickness: np.ndarray) -> np.ndarray:
    return speed**2 + 3.0 * thickness**2 + speed * thickness


@pytest.mark.parametrize("speeds", [(2.0, 3.0, 5.0), (3.0, 5.0, 9.0), (1.0, 3.0, 5.0, 9.0)])
def test_interpolation__of_a_quadratic_has_the_error_of_its_chord(speeds: tuple[float, ...]) -> None:
    def law(speed: np.ndarray) -> np.ndarray:
        return 7.0 - 3.0 * speed + 0.5 * speed**2

    value, bar, how, _ = interpolate(grid(law, speed=speeds), "depth", {"speed": 3.5})
    assert bar == pytest.approx(value - law(np.array(3.5)))
    assert bar == pytest.approx(0.5 * 0.5 * 1.5)
    assert how == "linear between neighbouring runs; the error bar includes the interpolation error"


@pytest.mark.parametrize(
    ("speeds", "lost", "bar"),
    [(CUBIC, (), 9.0 / 4.0), (CUBIC, (4.0,), 6.0 / 4.0), ((2.0, 3.0, 4.0), (4.0,), 19.0 / 2.0)],
    ids=["larger bend of both sides", "other side of a failed run", "no third run"],
)
def test_interpolation__takes_its_error_from_the_runs_that_have_a_value(
    speeds: tuple[float, ...], lost: tuple[float, ...], bar: float
) -> None:
    dataset = grid(cubic, speed=speeds)
    for speed in lost:
        failed(dataset, speed=speed)
    assert interpolate(dataset, "depth", {"speed": 2.5})[1] == pytest.approx(bar)


def test_interpolation__along_two_axes_has_the_errors_of_both_chords() -> None:
    at = {"speed": 2.5, "plate_thickness": 1.5}
    value, bar, *_ = interpolate(grid(bowl, **AXES), "depth", at)
    assert bar == pytest.approx(value - bowl(np.array(2.5), np.array(1.5)))
    along_speed_alone = interpolate(grid(bowl, **AXES), "depth", {**at, "plate_thickness": 3.0})
    assert along_speed_alone[1] == pytest.approx(0.5 * 1.5)


def test_shot_on_a_run__has_the_value_and_the_error_bar_of_the_run() -> None:
    at = {"speed": 2.0, "plate_thickness": 3.0}
    assert interpolate(grid(bowl, 0.25, **AXES), "depth", at)[:3] == (37.0, 0.25, "computed")


@pytest.mark.parametrize(
    ("at", "reason"),
    [
        ({"speed": 9.0, "plate_thickness": 3.0}, "the shot lies outside the axis speed"),
        ({"speed": 3.0}, "the shot does not state plate thickness"),
        ({"speed": 1.5, "plate_thickness": 1.0}, "a neighbouring run has no comparable value"),
        ({"speed": 2.0, "plate_thickness": 3.0, "target": "tin"}, "the shot has another target"),
    ],
)
def test_shot_that_no_run_answers__says_why(at: dict[str, float | str], reason: str) -> None:
    dataset = failed(grid(bowl, **AXES), speed=1.0, plate_thickness=1.0).assign(target="lead")
    value, _, how, _ = interpolate(dataset, "depth", at)
    assert math.isnan(value)
    assert how.startswith(reason)


def test_shot_in_a_zip__is_matched_by_the_run_with_its_parameters_alone() -> None:
    dataset = xr.Dataset(
        {
            "depth": ("run", [1.0, 4.0, 9.0]),
            "depth_reading_uncertainty": ("run", [0.1, 0.2, 0.3]),
            "depth_flags": ("run", [0] * 3, FLAGS),
            "run_state": ("run", [SUCCEEDED] * 3),
        },
        coords={"speed": ("run", [1.0, 2.0, 3.0]), "plate_thickness": ("run", [3.0, 2.0, 1.0])},
        attrs={"axes": "speed plate_thickness", "refinements": "", "measurement_versions": "{}"},
    )
    at = {"speed": 2.0, "plate_thickness": 2.0}
    assert interpolate(dataset, "depth", at)[:3] == (4.0, 0.2, "computed")
    assert interpolate(dataset, "depth", {**at, "speed": 2.5}).how == "no run has the parameters of the shot"
