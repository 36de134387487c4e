"""Methods side by side: differences beside the bars of both, and their sentences."""

import math

import pytest
import xarray as xr

from studies.reports.compare import compare
from studies.reports.methods import methods_of
from studies.sweeps.axes import Axis
from studies.sweeps.sweep import Sweep
from tests.studies.support import fakes
from tests.studies.support.fakes import sweep_of

SPEED = Axis("speed", "m s-1", (2e3, 7e3))
SWEEP = sweep_of(fakes.METHODS, SPEED, resolutions=fakes.CELLS, offsets=fakes.OFFSETS, fixed=fakes.BY_BOTH)


def cube_of(sweep: Sweep, factor: float) -> xr.Dataset:
    """A cube whose holes by sph are so many times as wide."""
    outcomes = fakes.results(sweep)
    for point in sweep.runs():
        if point.coordinates.get("method") == "sph":
            outcomes[point.run.id] = fakes.scaled(outcomes[point.run.id], factor)
    return fakes.cube_of(sweep, outcomes)


@pytest.mark.parametrize(
    ("factor", "says"),
    [
        (0.7, "30\u202f% smaller than by mpm (2 points): more than the error bars of both together."),
        (1.02, "2\u202f% larger than by mpm (2 points): no more than the error bars of both together."),
    ],
)
def test_methods__are_compared_by_the_bars_of_both(factor: float, says: str) -> None:
    dataset = cube_of(SWEEP, factor)
    document = methods_of(dataset, compare(dataset).points)
    assert document is not None
    [hole] = document["quantities"]
    assert hole["sentences"] == [f"By method sph the hole diameter is {says}"]
    assert [row["at"]["speed"] for row in hole["rows"]] == [2e3, 7e3]
    for row in hole["rows"]:
        assert row["joint"] == pytest.approx(math.hypot(row["bar"], row["reference_bar"]))
        assert row["relative"] == pytest.approx(factor - 1.0)


def test_methods__without_a_mesh_error_say_that_nothing_is_known() -> None:
    dataset = cube_of(sweep_of(fakes.METHODS, SPEED, fixed=fakes.BY_BOTH), 0.9)
    document = methods_of(dataset, compare(dataset).points)
    assert document is not None
    assert "lack the mesh" in document["quantities"][0]["sentences"][0]
