"""The model part in a cube: stored, screened, or not assessed with a reason."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.cubes import cube
from studies.cubes.models import BASE, stored_shares
from studies.reports import report
from studies.reports.compare import compare
from studies.runs.results import RunResult
from studies.sweeps.screening import EOS, FAILURE, STRENGTH, STRONGER, WEAKER
from studies.sweeps.sweep import Sweep
from tests.studies.sweeps.test_screening import DOCUMENT

HOLE = 20e-3
SPALL, OTHER_EOS = "failure spall-rate", "equation of state of copper-ofhc-tillotson"
ANSWERS = {STRONGER: 19.8e-3, WEAKER: 20.2e-3, SPALL: 20.3e-3, OTHER_EOS: 19.6e-3}
EXPECTED = HOLE * np.hypot(0.01, np.hypot(0.015, 0.02))


def results_of(sweep: Sweep, screens: dict[str, float]) -> dict[str, Any]:
    """A hole of 20 mm in each run, and these values in the runs that screen the models; the others failed."""
    values = {point.run.id: HOLE for point in sweep.runs()}
    for point in [*sweep.every_run()][sweep.size :]:
        values[point.run.id] = screens.get(str(point.coordinates["screening"]), np.nan)
    return {run_id: _result(run_id, value) for run_id, value in values.items()}


def _result(run_id: str, value: float) -> Any:
    if np.isnan(value):
        return RunResult("", "failed", "unphysical state")
    measured = {"value": value, "uncertainty": 1e-4, "parts": {"resolution": 1e-4}, "flags": []}
    hole = {**measured, "history": {}, "version": 4}
    plain = {"run_id": run_id, "state": "succeeded", "measurements": {"hole_diameter": hole}}
    return RunResult.from_json({**plain, "flags": []})


def built(model_part: str, screens: dict[str, float] | None = None, **changes: Any) -> Any:
    sweep = Sweep.parse({**DOCUMENT, "model_part": model_part, **changes})
    return cube.build(sweep, results_of(sweep, ANSWERS if screens is None else screens))


def contributions_in(dataset: xr.Dataset) -> dict[str, float | None]:
    """The contributions to the model part of the hole, as report.json has them."""
    rows = report.document(dataset, compare(dataset))["model_part"]
    (row,) = [row for row in rows if row["quantity"] == "hole_diameter"]
    assert row["runs"] == dataset.run_state.size
    contributions: dict[str, float | None] = row["contributions"]
    return contributions


def test_screened__is_the_share_of_each_value_and_no_point_of_the_cube() -> None:
    dataset = built("screen")
    assert dict(dataset.hole_diameter.sizes) == {"speed": 3, "cells_per_diameter": 2}
    np.testing.assert_allclose(dataset.hole_diameter_model_part, EXPECTED)
    assert dataset.hole_diameter_model_part.attrs["units"] == "m"
    reason = str(dataset.hole_diameter_model_part_reason.values.flat[0])
    assert "strength 1 %, failure 1.5 %, equation of state 2 % (screening runs" in reason
    expected = {STRENGTH: 0.01, FAILURE: 0.015, EOS: 0.02}
    assert contributions_in(dataset) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("model_part", "screens", "reason"),
    [
        ("none", None, "not assessed: model_part is none"),
        ("screen", {}, "not assessed: screening runs at the middle of the sweep; strength +10%: its scr"),
    ],
)
def test_not_assessed__is_nan_with_the_reason(model_part: str, screens: dict[str, float] | None, reason: str) -> None:
    dataset = built(model_part, screens)
    assert np.isnan(dataset.hole_diameter_model_part).all()
    assert set(contributions_in(dataset).values()) == {None}
    assert str(dataset.hole_diameter_model_part_reason.values.flat[0]).startswith(reason)


@pytest.mark.claim("mend-again", "model-part-from-elsewhere")
def test_stored__of_other_speeds_and_plates_says_how_far_away_it_was_measured() -> None:
    """A stored model part that is applied at t/d 0.75 and 2 km/s says by what factor it was measured elsewhere."""
    fixed: dict[str, Any] = {**DOCUMENT["fixed"]}  # type: ignore[dict-item]
    del fixed["plate_thickness"]
    axes = {"speed": ["2 km/s", "5 km/s"], "plate_thickness": ["2 mm", "6 mm"]}
    dataset = built("stored", fixed=fixed, axes=axes)
    assert "at t/d 0.25, 3 to 7 km/s" in str(dataset.hole_diameter_model_part_reason.values.flat[0])
    # 2 of 3 km/s, and 0.75 of 0.25.
    factors = dataset.hole_diameter_model_part_distance.isel(cells_per_diameter=-1)
    np.testing.assert_allclose(factors, [[1.5, 3.0], [1.0, 3.0]])
    document = report.document(dataset, compare(dataset))
    assert {row["distance"] for row in document["model_part"] if row["distance"]} == {3.0}
    assert "measured at other speeds or plates (t/d) for 3 of 4 points, up to a factor of 3 away" in " ".join(
        document["verdict"]["unchecked"]
    )


def test_stored__of_a_thick_plate_is_as_far_away_as_its_speed() -> None:
    """It has no thickness over the diameter, and 10 km/s are a factor of 10/7 from the fastest that is stored."""
    fixed = {name: value for name, value in DOCUMENT["fixed"].items() if name != "plate_thickness"}  # type: ignore[attr-defined]
    dataset = built("stored", scenario="thick_plate", fixed=fixed, axes={"speed": ["7 km/s", "10 km/s"]})
    np.testing.assert_allclose(dataset.crater_depth_model_part_distance.isel(cells_per_diameter=0), [1.0, 10.0 / 7.0])


def test_stored__of_another_alloy_names_the_alloy_that_it_is_of() -> None:
    names = {"copper-ofhc": "", "our-copper": "OFHC copper"}
    dataset = built(
        "stored",
        materials={"our-copper": {"base": "copper-ofhc", "alloy": "C11000"}},
        axes={**DOCUMENT["axes"], "target": list(names)},  # type: ignore[dict-item]
        fixed={name: value for name, value in DOCUMENT["fixed"].items() if name != "target"},  # type: ignore[attr-defined]
    )
    alloys = dataset.hole_diameter_model_part_alloy
    for target, alloy in names.items():
        assert {*alloys.sel(target=target).values.flat} == {alloy}


def test_contribution__that_one_speed_does_not_tell_is_that_of_the_others_and_not_zero() -> None:
    answers = {BASE: [1.0, 1.0, 1.0], SPALL: [1.1, 1.3, None], STRONGER: [None, None, 1.2]}
    entry = {"speeds": [3e3, 5e3, 7e3], "quantities": {"hole_diameter": answers}}
    assert stored_shares(entry, "hole_diameter", 4e3) == pytest.approx({FAILURE: 0.2, STRENGTH: 0.2})
    assert stored_shares(entry, "hole_diameter", 7e3) == pytest.approx({FAILURE: 0.3, STRENGTH: 0.2})
