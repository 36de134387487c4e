"""The model part in a cube: stored, screened, or not assessed with a reason."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.cubes import cube
from studies.cubes.models import BASE, classes, stored_failures, stored_shares
from studies.runs.results import RunResult
from studies.sweeps.screening import EOS, STRENGTH, STRONGER, WEAKER, thrown_out
from studies.sweeps.sweep import Sweep
from tests.studies.support import fakes
from tests.studies.sweeps.test_screening import DOCUMENT

HOLE = 20e-3
SPALL, OTHER_EOS = "failure spall-rate", "equation of state of copper-ofhc-tillotson"
ANSWERS = {STRONGER: 19.8e-3, WEAKER: 20.2e-3, SPALL: 20.3e-3, OTHER_EOS: 19.6e-3}
EXPECTED = HOLE * np.hypot(0.01, 0.02)
DEFAULT, OUT = "void-growth", "johnson-cook"  # a failure that the rule leaves, and one that it throws out
FIXED: dict[str, Any] = {**DOCUMENT["fixed"]}  # type: ignore[dict-item]
NO_SIDE = {"share": 0.0, "failure": ""}


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


def stated_in(dataset: xr.Dataset) -> dict[str, Any]:
    """The model part of the hole, as report.json has it of all runs."""
    rows = fakes.document_of(dataset)["models"]["parts"]
    (row,) = [row for row in rows if row["quantity"] == "hole_diameter"]
    assert row["runs"] == dataset.run_state.size
    stated: dict[str, Any] = row
    return stated


def test_screened__is_the_share_of_each_value_and_no_point_of_the_cube() -> None:
    dataset = built("screen")
    assert dict(dataset.hole_diameter.sizes) == {"speed": 3, "cells_per_diameter": 2}
    np.testing.assert_allclose(dataset.hole_diameter_model_part, EXPECTED)
    assert dataset.hole_diameter_model_part.attrs["units"] == "m"
    reason = str(dataset.hole_diameter_model_part_reason.values.flat[0])
    assert "strength 1 %, equation of state 2 %, failure void-growth +0 %, thrown out: spall-rate +1.5 % (scr" in reason
    row = stated_in(dataset)
    assert row["contributions"] == pytest.approx({STRENGTH: 0.01, EOS: 0.02})
    assert (row["lower"], row["upper"], row["thrown_out"]) == (NO_SIDE, NO_SIDE, ["spall-rate"])


def test_failure_that_counts__makes_a_part_of_one_side_and_no_symmetric_one() -> None:
    """Of a run that breaks otherwise than the default, the default makes one side; what is thrown out makes none."""
    answers = {**ANSWERS, f"failure {DEFAULT}": 19e-3, "failure none": 15e-3}
    dataset = built("screen", answers, fixed={**FIXED, "failure": OUT})
    assert {OUT, "none", "spall-rate"} <= thrown_out().keys()
    assert DEFAULT not in thrown_out()
    np.testing.assert_allclose(dataset.hole_diameter_model_part, EXPECTED)
    np.testing.assert_allclose(dataset.hole_diameter_model_part_lower, 1e-3)
    np.testing.assert_allclose(dataset.hole_diameter_model_part_upper, 0.0, atol=1e-9)
    assert dataset.hole_diameter_model_part_lower.attrs["units"] == "m"
    row = stated_in(dataset)
    assert row["lower"] == {"share": pytest.approx(0.05), "failure": DEFAULT}
    assert row["thrown_out"] == ["none", "spall-rate"]


def test_failure_on_an_axis__has_the_one_sided_part_from_the_failure_of_each_run() -> None:
    """The middle of the sweep is one of them; both compare with the same answers."""
    axes = {"failure": [DEFAULT, OUT]}
    fixed = {**FIXED, "speed": "5 km/s"}
    middle = Sweep.parse({**DOCUMENT, "axes": axes, "fixed": fixed}).screening()[0].parameters["failure"]
    other = OUT if middle == DEFAULT else DEFAULT
    dataset = built("screen", {f"failure {other}": HOLE * (1.25 if other == OUT else 0.8)}, axes=axes, fixed=fixed)
    sides = [dataset[f"hole_diameter_model_part_{side}"] for side in ("lower", "upper")]
    for failure, lower in ((DEFAULT, 0.0), (OUT, 0.2 * HOLE)):
        got = [side.sel(failure=failure).values for side in sides]
        np.testing.assert_allclose(got[0], lower, atol=1e-9)
        np.testing.assert_allclose(got[1], 0.0, atol=1e-9)


def test_failures_that_are_all_thrown_out__leave_the_one_sided_part_unknown() -> None:
    """Of a metal that has no constants of the default, with an answer of one that is thrown out alone."""
    dataset = built("screen", {STRONGER: 19.8e-3, "failure spall-rate": 25e-3}, fixed={**FIXED, "failure": "none"})
    np.testing.assert_allclose(dataset.hole_diameter_model_part, 0.01 * HOLE)
    assert "hole_diameter_model_part_lower" not in dataset
    row = stated_in(dataset)
    assert (row["lower"], row["upper"], row["thrown_out"]) == (None, None, ["spall-rate"])
    assert "failure not assessed, thrown out: spall-rate +25 %" in row["statement"]


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
    row = stated_in(dataset)
    assert {*row["contributions"].values(), row["lower"], row["upper"]} == {None}
    assert row["thrown_out"] == []
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
    document = fakes.document_of(dataset)
    assert {row["distance"] for row in document["models"]["parts"] if row["distance"]} == {3.0}
    (distant,) = [each for each in document["laws"]["unchecked"] if each["code"] == "distant_models"]
    assert (distant["count"], distant["of"], distant["factor"]) == (3, 4, 3.0)
    # A thick plate has no thickness over the diameter, and 10 km/s are a factor of 10/7 from the fastest.
    thick = built("stored", scenario="thick_plate", fixed=fixed, axes={"speed": ["7 km/s", "10 km/s"]})
    np.testing.assert_allclose(thick.crater_depth_model_part_distance.isel(cells_per_diameter=0), [1.0, 10.0 / 7.0])


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
    told: dict[str, list[float | None]] = {BASE: [1.0, 1.0, 1.0], SPALL: [1.1, 1.3, None], STRONGER: [None, None, 1.2]}
    entry = classes()[0] | {"failure": DEFAULT, "speeds": [3e3, 5e3, 7e3], "quantities": {"hole_diameter": told}}
    for speed, spall in ((4e3, 0.2), (7e3, 0.3)):
        assert stored_shares(entry, "hole_diameter", speed) == pytest.approx({STRENGTH: 0.2})
        assert stored_failures(entry, "hole_diameter", speed, DEFAULT) == pytest.approx({"spall-rate": spall})
    assert stored_failures(entry, "hole_diameter", 3e3, "spall-rate") == pytest.approx({DEFAULT: 1.0 / 1.1 - 1.0})
    assert stored_failures(entry, "hole_diameter", 3e3, "spall") == {}
