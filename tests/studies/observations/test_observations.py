"""Shots: their tables, with every row named when refused, and what runs around them say of them."""

import math
from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr

from studies.observations import Known, Observation, read_observations
from studies.reports.points import SUCCEEDED
from studies.reports.sightings import bring_to
from studies.values.errors import InvalidInput
from studies.values.parameters import Parameter, Value

KNOWN = Known(
    quantities={"hole_diameter": "m", "crater_depth_over_diameter": "1"},
    parameters={
        "speed": Parameter(name="speed", kind="quantity", unit="m s-1", minimum=100.0),
        "target": Parameter(name="target", kind="material"),
        "target.strength.A": Parameter(name="A", kind="quantity", unit="Pa"),
    },
    materials=("copper-ofhc",),
)

FLAGS = {"flag_masks": [1, 2], "flag_meanings": "closed_on_axis near_rim"}

TABLE = """\
# shots of last week
speed [km/s], target, quantity, value [mm], uncertainty, source

6, copper-ofhc, hole_diameter, 19.0, 0.3 mm, "Ma (2005), Fig. 3.2"
2.0 km/s, , hole_diameter, 1.5 cm, , own shot 17
"""


def refused(given: object) -> str:
    with pytest.raises(InvalidInput) as caught:
        read_observations(given, KNOWN)
    return str(caught.value)


def test_read_observations__takes_units_from_header_or_cell() -> None:
    first, second = read_observations(TABLE, KNOWN)
    parameters: dict[str, Value] = {"speed": 6000.0, "target": "copper-ofhc"}
    assert first == Observation("hole_diameter", 0.019, 0.0003, "Ma (2005), Fig. 3.2", parameters)
    assert second == Observation("hole_diameter", 0.015, None, "own shot 17", {"speed": 2000.0})


def test_read_observations__takes_a_list_of_mappings() -> None:
    row = {"speed": "6 km/s", "quantity": "hole_diameter", "value": "19 mm", "source": "shot 1"}
    (shot,) = read_observations([row], KNOWN)
    assert (shot.value, shot.uncertainty) == (0.019, None)


def test_document__reads_back_as_the_same_shots() -> None:
    shots = read_observations(TABLE, KNOWN)
    rows = [shot.document(KNOWN) for shot in shots]
    assert read_observations(rows, KNOWN) == shots


def test_read_observations__of_a_column_given_twice_is_refused() -> None:
    table = "quantity,value,source,speed [km/s],speed [m/s]\nhole_diameter,19 mm,x,3,9000\n"
    with pytest.raises(InvalidInput, match="each column once"):
        read_observations(table, KNOWN)


def test_read_observations__takes_a_plain_ratio() -> None:
    table = "quantity,value,source\ncrater_depth_over_diameter,0.55,x\n"
    assert read_observations(table, KNOWN)[0].value == 0.55


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("6,hole_diameter,,0.3 mm,x", ["line 3", "value"]),
        ("6,hole_diameter,19,0.3 mm,x", ["line 3: value", "19 mm"]),
        ("6,hole_diameter,19 kg,0.3 mm,x", ["line 3: value", "length"]),
        ("6,hole_diameter,-19 mm,0.3 mm,x", ["line 3: value", "0 um"]),
        ("6,hole_diameter,19 mm,-1 mm,x", ["line 3: uncertainty"]),
        ("6,hole_diametre,19 mm,0.3 mm,x", ["line 3: quantity", "did you mean 'hole_diameter'"]),
        ("6,hole_diameter,19 mm,0.3 mm,", ["line 3", "source"]),
        ("6,hole_diameter,19 mm", ["line 3", "3 cells", "5 cells"]),
        ("1e-3,hole_diameter,19 mm,,x", ["line 3: speed", "100 m/s"]),
        ("nan,hole_diameter,19 mm,,x", ["line 3: speed"]),
    ],
)
def test_read_observations__names_the_row_and_the_column(line: str, words: list[str]) -> None:
    table = "speed [km/s],quantity,value,uncertainty,source\n"
    message = refused(table + "3,hole_diameter,12 mm,,x\n" + line)
    assert all(word in message for word in words), message


def test_read_observations__tells_every_row_that_is_wrong() -> None:
    message = refused("quantity,value,source\nhole_diameter,3,x\nhole_diameter,3 kg,x\n")
    assert "line 2" in message
    assert "line 3" in message


@pytest.mark.parametrize(
    "given", [None, 3, "", "\n\n", {"a": 1}, [3], [["speed"]], [{3: "x"}], 'a,"b\n']
)
def test_read_observations__of_no_table_is_refused(given: object) -> None:
    refused(given)


def test_read_observations__of_an_unknown_column_gives_the_nearest() -> None:
    assert "did you mean 'speed'" in refused("sped,quantity,value,source\n1,hole_diameter,1 mm,x")


def test_read_observations__takes_a_constant_of_a_material() -> None:
    table = "target.strength.A [MPa],quantity,value [mm],source\n90,hole_diameter,15,x"
    assert read_observations(table, KNOWN)[0].parameters == {"target.strength.A": 90e6}


# ---- between runs --------------------------------------------------------------------------------


def grid(
    law: Callable[..., np.ndarray], bar: float = 0.0, /, **axes: tuple[float, ...]
) -> xr.Dataset:
    """Runs over all combinations of axis values that measure exactly a law, each with an error bar."""
    value = law(*np.meshgrid(*axes.values(), indexing="ij"))
    dims = tuple(axes)
    return xr.Dataset(
        {
            "depth": (dims, value),
            "depth_uncertainty": (dims, np.full(value.shape, bar)),
            "depth_flags": (dims, np.zeros(value.shape, np.int32), FLAGS),
            "run_state": (dims, np.full(value.shape, SUCCEEDED)),
        },
        coords={name: list(values) for name, values in axes.items()},
        attrs={"axes": " ".join(axes)},
    )


def failed(dataset: xr.Dataset, **at: float) -> xr.Dataset:
    """The runs with one run failed."""
    dataset.run_state.loc[at] = SUCCEEDED + 1
    return dataset


def two_thirds(speed: np.ndarray) -> np.ndarray:
    return 2.28 * (speed / 3.94) ** (2.0 / 3.0)


@pytest.mark.parametrize("speeds", [(2.0, 3.0, 5.0), (3.0, 5.0, 9.0), (1.0, 3.0, 5.0, 9.0)])
def test_interpolation__of_a_quadratic_has_the_error_of_its_chord(
    speeds: tuple[float, ...],
) -> None:
    def law(speed: np.ndarray) -> np.ndarray:
        return 7.0 - 3.0 * speed + 0.5 * speed**2

    value, bar, how = bring_to(grid(law, speed=speeds), "depth", {"speed": 3.5})
    assert bar == pytest.approx(value - law(np.array(3.5)))
    assert bar == pytest.approx(0.5 * 0.5 * 1.5)
    assert how == "linear between neighbouring runs; the error bar holds the interpolation's part"


def test_interpolation__takes_the_side_that_bends_more() -> None:
    """Of x^3, f[2, 3, 1] = 6 and f[2, 3, 4] = 9."""
    dataset = grid(lambda speed: speed**3, speed=(1.0, 2.0, 3.0, 4.0))
    assert bring_to(dataset, "depth", {"speed": 2.5})[1] == pytest.approx(9.0 / 4.0)


@pytest.mark.parametrize("speeds", [(2.0, 7.0), (1.0, 2.0, 7.0)])
def test_interpolation__of_the_two_thirds_law_is_inside_its_bar(speeds: tuple[float, ...]) -> None:
    value, bar, _ = bring_to(grid(two_thirds, speed=speeds), "depth", {"speed": 4.5})
    true = float(two_thirds(np.array(4.5)))
    assert 1.0 - value / true == pytest.approx(0.0375, abs=5e-4)
    assert abs(value - true) <= bar


@pytest.mark.parametrize(("speed", "share"), [(4.5, 1.0), (3.25, 0.75), (5.75, 0.75)])
def test_interpolation__between_two_values_has_up_to_half_their_difference(
    speed: float, share: float
) -> None:
    dataset = grid(lambda speed: 10.0 * speed, speed=(2.0, 7.0))
    assert bring_to(dataset, "depth", {"speed": speed})[1] == pytest.approx(25.0 * share)


def test_interpolation__takes_the_other_side_of_a_failed_run() -> None:
    dataset = failed(grid(lambda speed: speed**3, speed=(1.0, 2.0, 3.0, 4.0)), speed=4.0)
    assert bring_to(dataset, "depth", {"speed": 2.5})[1] == pytest.approx(6.0 / 4.0)


def test_interpolation__next_to_failed_runs_alone_is_that_of_two_values() -> None:
    dataset = failed(grid(lambda speed: speed**3, speed=(2.0, 3.0, 4.0)), speed=4.0)
    assert bring_to(dataset, "depth", {"speed": 2.5})[1] == pytest.approx(19.0 / 2.0)


def bowl(speed: np.ndarray, thickness: np.ndarray) -> np.ndarray:
    return speed**2 + 3.0 * thickness**2 + speed * thickness


AXES = {"speed": (1.0, 2.0, 4.0), "plate_thickness": (1.0, 3.0, 4.0)}


def test_interpolation__along_two_axes_has_the_errors_of_both_chords() -> None:
    at = {"speed": 2.5, "plate_thickness": 1.5}
    value, bar, _ = bring_to(grid(bowl, **AXES), "depth", at)
    assert bar == pytest.approx(value - bowl(np.array(2.5), np.array(1.5)))
    assert bar == pytest.approx(0.5 * 1.5 + 3.0 * 0.5 * 1.5)


def test_interpolation__adds_nothing_along_an_axis_that_was_computed() -> None:
    at = {"speed": 2.5, "plate_thickness": 3.0}
    assert bring_to(grid(bowl, **AXES), "depth", at)[1] == pytest.approx(0.5 * 1.5)


def test_shot_on_a_run__has_the_error_bar_of_the_run() -> None:
    at = {"speed": 2.0, "plate_thickness": 3.0}
    assert bring_to(grid(bowl, 0.25, **AXES), "depth", at) == (37.0, 0.25, "computed")


def test_interpolation__adds_to_the_error_bars_of_the_runs_as_a_root_of_squares() -> None:
    dataset = grid(lambda speed: speed**2, 1.0, speed=(1.0, 2.0, 4.0))
    assert bring_to(dataset, "depth", {"speed": 2.5})[1] == pytest.approx(math.hypot(1.0, 0.75))


def test_interpolation__gives_no_error_bar_where_the_runs_have_none() -> None:
    dataset = grid(two_thirds, math.nan, speed=(2.0, 7.0))
    value, bar, how = bring_to(dataset, "depth", {"speed": 4.5})
    assert math.isfinite(value)
    assert math.isnan(bar)
    assert how == "linear between neighbouring runs"


@pytest.mark.parametrize(("flag", "compared"), [(1, False), (2, True)])
def test_shot_on_a_run__that_closed_on_its_axis_is_not_compared(flag: int, compared: bool) -> None:
    dataset = grid(lambda speed: speed, speed=(1.0, 2.0))
    dataset["depth_flags"][0] = flag
    assert math.isfinite(bring_to(dataset, "depth", {"speed": 1.0})[0]) == compared


def test_shot_in_a_zip__has_the_error_bar_of_its_run() -> None:
    dataset = xr.Dataset(
        {
            "depth": ("run", [1.0, 4.0, 9.0]),
            "depth_uncertainty": ("run", [0.1, 0.2, 0.3]),
            "depth_flags": ("run", [0] * 3, FLAGS),
            "run_state": ("run", [SUCCEEDED] * 3),
        },
        coords={"speed": ("run", [1.0, 2.0, 3.0]), "plate_thickness": ("run", [3.0, 2.0, 1.0])},
        attrs={"axes": "speed plate_thickness"},
    )
    at = {"speed": 2.0, "plate_thickness": 2.0}
    assert bring_to(dataset, "depth", at) == (4.0, 0.2, "computed")
    assert "no run has" in bring_to(dataset, "depth", {"speed": 2.5, "plate_thickness": 2.0})[2]
