"""Methods side by side: differences beside the bars of both."""

import math

import pytest
import xarray as xr

from studies.methods.differences import methods_of
from studies.methods.section import Methods
from studies.reports.compare import compare
from studies.reports.section import Source
from studies.sweeps.axes import Axis
from studies.sweeps.sweep import Sweep
from tests.studies.support import fakes
from tests.studies.support.fakes import sweep_of

SPEED = Axis("speed", "m s-1", (2e3, 7e3))
SWEEP = sweep_of(fakes.METHODS, SPEED, resolutions=fakes.CELLS, offsets=fakes.OFFSETS, fixed=fakes.BY_BOTH)


def reported(sweep: Sweep, factor: float) -> tuple[Methods, str]:
    """The section of a cube whose holes by sph are so many times as wide, and its words for the headline."""
    outcomes = fakes.results(sweep)
    for point in sweep.runs():
        if point.coordinates.get("method") == "sph":
            outcomes[point.run.id] = fakes.scaled(outcomes[point.run.id], factor)
    dataset: xr.Dataset = fakes.cube_of(sweep, outcomes)
    part = methods_of(Source(dataset, compare(dataset), {}))
    assert part is not None
    assert isinstance(part.record, Methods)
    return part.record, part.opening


@pytest.mark.parametrize(("factor", "beyond", "says"), [(0.7, 2, "−30\u202f%"), (1.02, 0, "+2\u202f%")])
def test_methods__are_compared_by_the_bars_of_both(factor: float, beyond: int, says: str) -> None:
    methods, opening = reported(SWEEP, factor)
    [hole] = methods.quantities
    [sph] = hole.methods
    assert (sph.points, sph.judged, sph.beyond) == (2, 2, beyond)
    assert (sph.smallest, sph.largest) == pytest.approx((factor - 1.0, factor - 1.0))
    assert opening.startswith(f"Hole diameter by sph: {says} beside mpm; ±")
    assert [row.at["speed"] for row in hole.rows] == [2e3, 7e3]
    for row in hole.rows:
        assert row.bar is not None
        assert row.reference_bar is not None
        assert row.joint == pytest.approx(math.hypot(row.bar, row.reference_bar))
        assert row.relative == pytest.approx(factor - 1.0)


def test_methods__without_a_mesh_error_say_that_nothing_is_known() -> None:
    methods, opening = reported(sweep_of(fakes.METHODS, SPEED, fixed=fakes.BY_BOTH), 0.9)
    assert methods.quantities[0].methods[0].judged == 0
    assert opening.endswith("beside mpm; mesh error unknown.")
