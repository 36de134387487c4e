"""Points: converged values over resolutions and offsets, in the cube and in what reads it."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.convergence.richardson import Sample, converge_series
from studies.cubes import cube
from studies.cubes.cells import MissingResult
from studies.cubes.points import points_of, refined
from studies.cubes.variables import STATES, VERDICT_WORDS
from studies.quantities.measured import DEFINITION
from studies.runs.run import Run
from studies.sweeps.axes import Axis
from studies.sweeps.reading import RESOLUTION
from studies.sweeps.sweep import Sweep
from tests.studies.support import fakes
from tests.studies.support.fakes import sweep_of

SWEEP = fakes.refined_holes()
ZIP = sweep_of(
    Axis("speed", "m s-1", (5e3, 2e3)),
    Axis("plate_thickness", "m", (2e-3, 3e-3)),
    combine="zip",
    resolutions=fakes.CELLS,
    offsets=fakes.OFFSETS,
)


def built(sweep: Sweep = SWEEP, **replaced: Any) -> xr.Dataset:
    return cube.build(sweep, {**fakes.results(sweep), **replaced}, fakes.catalogue())


def run_at(sweep: Sweep, **coordinates: float) -> Run:
    (entry,) = [p.run for p in sweep.runs() if coordinates.items() <= p.coordinates.items()]
    return entry


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
        refined(dataset, "hole_diameter"), converge_series(samples.values()), fakes.VERDICTS.items(), strict=True
    ):
        cell = dataset.sel(speed=speed)
        assert VERDICT_WORDS[int(cell.hole_diameter_converged_verdict)] == verdict.replace(" ", "_")
        assert float(cell.hole_diameter_converged_uncertainty) == expected.uncertainty
        assert point.converged.verdict == expected.verdict == verdict
        for part in ("value", "mesh", "offsets", "measurement", "order", "extrapolated", "gci"):
            np.testing.assert_equal(getattr(point.converged, part), getattr(expected, part))
        levels = [(level.spacing, level.value, level.scatter) for level in point.converged.levels]
        assert levels == [(level.spacing, level.value, level.scatter) for level in expected.levels]


def test_series__has_the_points_that_differ_in_numbers_and_another_for_each_word() -> None:
    axes = (Axis("speed", "m s-1", (2e3, 4e3)), fakes.METHODS)
    sweep = sweep_of(*axes, fixed=fakes.BY_BOTH, resolutions=fakes.CELLS, offsets=fakes.OFFSETS)
    results = fakes.results(sweep)
    for point in sweep.runs():  # of first order; oscillates at 4 km/s with one of the methods
        if point.coordinates["method"] == "mpm" and point.coordinates["speed"] == 4e3:
            at_2 = replace(point.run, parameters={**point.run.parameters, "speed": 2e3})
            results[point.run.id] = results[at_2.id]
    dataset = cube.build(sweep, results, fakes.catalogue())
    extrapolated = dataset.hole_diameter_converged == dataset.hole_diameter_converged_extrapolated
    assert extrapolated.sel({"method": "mpm"}).all()
    assert not extrapolated.sel({"method": "sph"}).any()


@pytest.mark.parametrize(
    ("cells", "offsets", "dims"),
    [
        ((16.0,), 1, ("speed",)),
        ((16.0,), fakes.OFFSETS, ("speed", "offset")),
        ((16.0, 32.0), 1, ("speed", "cells_per_diameter")),
    ],
)
def test_refinement__is_a_dimension_only_where_there_are_several(
    cells: tuple[float, ...], offsets: int, dims: tuple[str, ...]
) -> None:
    dataset = built(fakes.refined_holes(cells, offsets))
    assert dataset.hole_diameter.dims == dims
    assert ("hole_diameter_converged" in dataset) == (len(dims) > 1)


def test_zip__is_refined_along_its_runs() -> None:
    dataset = built(ZIP)
    assert dataset.hole_diameter.dims == ("run", "cells_per_diameter", "offset")
    assert dataset.speed.dims == dataset.hole_diameter_converged.dims == ("run",)
    for point in ZIP.runs():
        places = dict(zip(dataset.hole_diameter.dims, point.index, strict=True))
        assert dataset.isel(places).run_id.item() == point.run.id


def test_failed_run__leaves_its_point_with_the_others_and_says_so() -> None:
    lost = run_at(SWEEP, speed=2e3, cells_per_diameter=64.0, offset=0.0)
    late = replace(fakes.result(lost), state="failed", reason="late")
    for result in (MissingResult("crashed", "out of luck"), late):
        dataset = built(SWEEP, **{lost.id: result})
        cell = dataset.sel(speed=2e3)
        assert "1 of 3 offsets without a value" in cell.hole_diameter_converged_reason.item()
        assert np.isfinite(cell.hole_diameter_converged)
        xr.testing.assert_identical(
            dataset.hole_diameter_converged.sel(speed=slice(3e3, None)),
            built().hole_diameter_converged.sel(speed=slice(3e3, None)),
        )


def test_point_without_results__has_a_verdict_too() -> None:
    dataset = cube.build(SWEEP, {}, fakes.catalogue())
    assert (dataset.hole_diameter_converged_verdict == VERDICT_WORDS.index("no_value")).all()
    assert dataset.hole_diameter_converged_uncertainty.isnull().all()


def test_finest_run_that_is_not_perforated__leaves_the_mesh_error_unknown() -> None:
    finest = run_at(SWEEP, speed=2e3, cells_per_diameter=64.0, offset=0.0)
    held = replace(fakes.measured(0.01, "not_perforated"), value=None, uncertainty=None)
    outcomes = {finest.id: replace(fakes.result(finest), measurements={"hole_diameter": held})}
    (point, *_) = refined(built(SWEEP, **outcomes), "hole_diameter")
    assert point.converged.verdict == "not in the asymptotic range"
    assert math.isnan(point.converged.mesh)
    assert math.isnan(point.converged.extrapolated)


# --- points -----------------------------------------------------------------------------------------


def test_points__of_a_cube_without_refinement_are_its_runs() -> None:
    dataset = cube.build(fakes.holes(), fakes.results(fakes.holes()), fakes.catalogue())
    assert points_of(dataset) is dataset


def test_points__have_converged_values_and_error_bars() -> None:
    dataset = built()
    points = points_of(dataset)
    assert points.run_state.dims == ("speed",)
    np.testing.assert_array_equal(points.hole_diameter, dataset.hole_diameter_converged)
    np.testing.assert_array_equal(points.hole_diameter_reading_uncertainty, dataset.hole_diameter_converged_uncertainty)


def test_part_of_the_definition__is_that_of_the_finest_runs_with_a_value_and_in_no_error_bar() -> None:
    def stated(**coordinates: float) -> dict[str, Any]:
        run = run_at(SWEEP, **coordinates)
        hole = fakes.result(run).measurements["hole_diameter"]
        part = 1e-3 * coordinates["offset"] if coordinates["cells_per_diameter"] == 64.0 else 9.0
        hole = replace(hole, parts={**hole.parts, DEFINITION: part})
        return {run.id: replace(fakes.result(run), measurements={"hole_diameter": hole})}

    offsets = np.unique([point.coordinates["offset"] for point in SWEEP.runs()]).tolist()
    outcomes: dict[str, Any] = {}
    for cells in (16.0, 32.0, 64.0):
        for offset in offsets:
            outcomes |= stated(speed=2e3, cells_per_diameter=cells, offset=offset)
    lost = run_at(SWEEP, speed=2e3, cells_per_diameter=64.0, offset=offsets[0])
    outcomes[lost.id] = MissingResult("crashed", "lost")
    points = points_of(built(SWEEP, **outcomes)).sel(speed=2e3)
    assert float(points.hole_diameter_definition_part) == pytest.approx(1e-3 * np.mean(offsets[1:]))
    assert float(points.hole_diameter_reading_uncertainty) < 1.0


def test_points__succeed_where_any_run_gave_a_value() -> None:
    runs = [p.run for p in SWEEP.runs()]
    first_speed = {run.id: MissingResult("cancelled", "enough") for run in runs[:9]}
    finest_of_last = {runs[-3].id: MissingResult("crashed", "out of luck")}
    points = points_of(built(SWEEP, **first_speed, **finest_of_last))
    states = [STATES[state] for state in points.run_state.values]
    assert (states[0], states[-1]) == ("cancelled", "succeeded")


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
