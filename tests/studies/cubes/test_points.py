"""Points: converged values over resolutions and offsets, in the cube and in what reads it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.convergence.richardson import Sample, converge
from studies.cubes.points import points_of, refined
from studies.cubes.variables import VERDICT_WORDS
from studies.sweeps.reading import RESOLUTION
from studies.sweeps.sweep import Sweep
from tests.studies.support import fakes

SWEEP = fakes.refined_holes()


def built(sweep: Sweep = SWEEP, **replaced: Any) -> xr.Dataset:
    return fakes.cube_of(sweep, {**fakes.results(sweep), **replaced})


# --- the cube ---------------------------------------------------------------------------------------


def test_converged__is_what_convergence_says_of_the_runs_of_a_point() -> None:
    dataset, results = built(), fakes.results(SWEEP)
    assert dataset.hole_diameter.dims == ("speed", "cells_per_diameter", "offset")
    assert dataset.hole_diameter_by_law.dims == ("speed", "hole_diameter_law")
    samples: dict[float, list[Sample]] = {speed: [] for speed in fakes.VERDICTS}
    for p in SWEEP.runs():
        m = results[p.run.id].measurements["hole_diameter"]
        spacing, speed = (float(p.coordinates[name] or 0.0) for name in (RESOLUTION, "speed"))
        samples[speed].append(Sample(1 / spacing, m.value, m.parts["resolution"], m.parts["growth"]))
    for point, expected, (speed, verdict) in zip(
        refined(dataset, "hole_diameter"), map(converge, samples.values()), fakes.VERDICTS.items(), strict=True
    ):
        cell = dataset.sel(speed=speed)
        assert VERDICT_WORDS[int(cell.hole_diameter_converged_verdict)] == verdict.replace(" ", "_")
        assert float(cell.hole_diameter_converged_uncertainty) == expected.uncertainty
        assert point.converged.verdict == expected.verdict == verdict
        for part in ("value", "mesh", "offsets", "measurement", "order", "extrapolated", "gci"):
            np.testing.assert_equal(getattr(point.converged, part), getattr(expected, part))
        levels = [(level.spacing, level.value, level.scatter) for level in point.converged.levels]
        assert levels == [(level.spacing, level.value, level.scatter) for level in expected.levels]


# --- points -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("finest_failed", [False, True])
def test_points__have_the_flags_of_the_runs_that_their_value_is_of(finest_failed: bool) -> None:
    outcomes = {}
    for point in SWEEP.runs():
        cells = point.coordinates["cells_per_diameter"]
        result = fakes.result(point.run)
        if point.coordinates["speed"] == 2e3 and cells != 64.0:
            result = replace(result, flags=("under_resolved",))
        elif point.coordinates["speed"] == 2e3 and finest_failed:
            result = replace(result, state="failed", reason="late")
        outcomes[point.run.id] = result
    dataset = built(SWEEP, **outcomes)
    points = points_of(dataset)
    assert list((points.run_flags != 0).values[:2]) == [finest_failed, False]
    assert points.run_flags.attrs.keys() == dataset.run_flags.attrs.keys()
    reason = dataset.hole_diameter_converged_reason.sel(speed=2e3).item()
    assert "under resolved at" in reason


def test_points__keep_their_model_part_where_the_first_of_the_finest_runs_failed() -> None:
    whole = points_of(built())
    first = next(p for p in SWEEP.runs() if p.coordinates[RESOLUTION] == 64.0 and p.coordinates["offset"] == 0.0)
    lost = replace(fakes.result(first.run), state="failed", reason="late", measurements={})
    points = points_of(built(SWEEP, **{first.run.id: lost}))
    np.testing.assert_allclose(points.hole_diameter_model_part, whole.hole_diameter_model_part, rtol=0.1)
    assert (
        points.hole_diameter_model_part_reason.values.tolist() == whole.hole_diameter_model_part_reason.values.tolist()
    )
