"""Mesh errors that experience tells, in the cube: the value without its error, the bar, and the raw reading beside."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from studies.convergence import experience
from studies.cubes.points import error_bars, points_of
from studies.cubes.variables import VERDICT_WORDS
from studies.sweeps.axes import Axis
from tests.studies.convergence.test_experience import KNOWN
from tests.studies.support import fakes

SPEEDS = Axis("speed", "m/s", (3e3, 6e3))


@pytest.fixture(autouse=True)
def known(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(experience, "stored", lambda: KNOWN)


def test_one_grid__has_the_value_without_its_mesh_error_and_a_bar() -> None:
    sweep = fakes.sweep_of(SPEEDS)
    cube, results = fakes.cube_of(sweep), fakes.results(sweep)
    for point, raw, value, bar in zip(
        sweep.runs(), cube.hole_diameter_raw, cube.hole_diameter, error_bars(cube, "hole_diameter"), strict=True
    ):
        error = point.run.mesh_errors.get("hole_diameter")
        reading = results[point.run.id].measurements["hole_diameter"]
        assert error is not None
        assert float(raw) == reading.value
        assert float(value) == pytest.approx(error.corrected(reading.value))
        rest = float(np.hypot(error.bar * float(value), reading.parts["growth"]))
        assert float(bar) == pytest.approx(rest)


@pytest.mark.parametrize(
    "changes", [{"failure": "none"}, {"courant": 0.2}, {"recipe": "thesis"}, {"plate_thickness": 1.2e-2}]
)
def test_set_up_without_experience__has_its_reading_and_no_bar(changes: dict[str, Any]) -> None:
    cube = fakes.cube_of(fakes.sweep_of(SPEEDS, fixed=changes))
    assert "hole_diameter_raw" not in cube
    assert np.isnan(error_bars(cube, "hole_diameter")).all()


@pytest.mark.parametrize(("factor", "verdict"), [(1.0, "mesh_error_known"), (1.3, "grids_disagree")])
def test_several_grids__are_one_value_or_disagree(factor: float, verdict: str) -> None:
    sweep = fakes.sweep_of(SPEEDS, resolutions=(16.0, 32.0), offsets=2)
    results = {}
    for point in sweep.runs():
        error = point.run.mesh_errors.get("hole_diameter")
        assert error is not None
        outcome = fakes.result(point.run)
        measured = outcome.measurements["hole_diameter"]
        is_coarse = point.coordinates["cells_per_diameter"] == 16.0
        value = 0.02 * np.exp(error.bias) * (factor if is_coarse else 1.0)
        results[point.run.id] = replace(outcome, measurements={"hole_diameter": replace(measured, value=value)})
    cube = fakes.cube_of(sweep, results)
    points = points_of(cube)
    assert {VERDICT_WORDS[int(each)] for each in cube.hole_diameter_converged_verdict} == {verdict}
    bars = error_bars(points, "hole_diameter").values
    assert (np.abs(points.hole_diameter.values - 0.02) <= bars).all()
    assert (bars < 0.02 * 0.06).all() == (factor == 1.0)


@pytest.mark.parametrize(("changes", "flagged"), [({}, False), ({"failure": "none"}, True)])
def test_coarse_run__is_flagged_where_its_mesh_error_is_unknown(changes: dict[str, Any], flagged: bool) -> None:
    sweep = fakes.sweep_of(SPEEDS, fixed=changes)
    coarse = {p.run.id: replace(fakes.result(p.run), flags=("under_resolved",)) for p in sweep.runs()}
    assert (fakes.cube_of(sweep, coarse).run_flags != 0).all() == flagged
