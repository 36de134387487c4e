"""Figures of points: the error bar about zero, what captions say of it, and which marks are open."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.cubes import cube
from studies.cubes.layout import MissingResult
from studies.reports.compare import compare
from studies.reports.figures import Figure, Series
from studies.reports.plot import plot
from studies.reports.report_figures import figures
from studies.reports.residual_figure import BAND
from tests.studies.support import fakes
from tests.studies.support.fakes import Sweep

REFINED = fakes.refined_holes()
OFFSETS_ALONE = fakes.refined_holes((16.0,))
TWO_GRIDS = fakes.refined_holes((16.0, 32.0), (0.0,))
PLAIN = fakes.holes()
LONELY = (
    4e3  # the speed at which only the finest resolution has a value, where coarse runs are lost
)


def without_coarse_runs(sweep: Sweep) -> dict[str, Any]:
    """Results with one resolution at one speed."""
    lost = [
        point.run.id
        for point in sweep.runs()
        if point.coordinates["speed"] == LONELY
        and point.coordinates["cells_per_diameter"] < max(sweep.refinements[0].values)
    ]
    return {**fakes.results(sweep), **dict.fromkeys(lost, MissingResult("crashed", "out of luck"))}


def built(sweep: Sweep, known: dict[str, Any] | None = None) -> xr.Dataset:
    return cube.build(sweep, known or fakes.results(sweep), fakes.catalogue())


def drawn(dataset: xr.Dataset, ending: str) -> Figure:
    (found,) = [
        one for one in figures(dataset, compare(dataset)) if one.name == f"hole_diameter_{ending}"
    ]
    return found


def bands(figure: Figure) -> list[Series]:
    return [one for panel in figure.panels for one in panel.series if one.label == BAND]


def open_speeds(dataset: xr.Dataset) -> list[Any]:
    """Where marks of the simulation are open."""
    (simulation,) = [
        one for one in drawn(dataset, "laws").panels[0].series if one.kind == "simulation"
    ]
    return [x for x, is_open in zip(simulation.x, simulation.flagged, strict=True) if is_open]


# --- the band ---------------------------------------------------------------------------------------


def test_band__is_the_error_bar_over_the_value_about_zero() -> None:
    dataset = built(REFINED)
    (band,) = bands(drawn(dataset, "residuals"))
    relative = dataset.hole_diameter_converged_uncertainty / dataset.hole_diameter_converged
    assert band.x == fakes.SPEEDS
    np.testing.assert_allclose(np.array(band.high, float), relative.values)
    np.testing.assert_allclose(np.array(band.low, float), -relative.values)


def test_band__holds_a_law_where_the_comparison_says_that_it_does() -> None:
    dataset = built(REFINED)
    (panel,) = drawn(dataset, "residuals").panels
    (law,) = [one for one in panel.series if one.label == "general form with the sound speed"]
    (band,) = [one for one in panel.series if one.label == BAND]
    inside = np.abs(np.array(law.y, float)) <= np.array(band.high, float)
    (found,) = [one for one in compare(dataset).residuals if one.subject == "maiden_c"]
    assert 0 < found.everywhere.within == inside.sum() < found.everywhere.judged == len(inside)


def test_band__does_not_reach_over_a_point_whose_mesh_error_is_unknown() -> None:
    figure = drawn(built(REFINED, without_coarse_runs(REFINED)), "residuals")
    assert [band.x for band in bands(figure)] == [(2e3, 3e3), (5e3, 6e3, 7e3)]
    assert "missing at 1 of 6 points, whose mesh error is unknown" in figure.caption


@pytest.mark.parametrize(
    ("sweep", "reason"),
    [
        (PLAIN, "every point is one run on one mesh"),
        (OFFSETS_ALONE, "every point has one resolution"),
    ],
    ids=["plain", "offsets"],
)
def test_band__is_absent_without_resolutions_and_the_caption_says_why(
    sweep: Sweep, reason: str
) -> None:
    figure = drawn(built(sweep), "residuals")
    assert bands(figure) == []
    assert f"No band about zero shows the error bar of the simulation: {reason}" in figure.caption


def test_band__is_explained_where_it_is_drawn() -> None:
    caption = drawn(built(REFINED), "residuals").caption
    assert "Grey about zero is the error bar of the simulation over its value" in caption
    assert "missing" not in caption


def test_band__lies_behind_the_marks_and_enters_the_legend_once() -> None:
    axes = (*REFINED.axes, fakes.Axis("plate_thickness", "m", (2e-3, 3e-3)))
    figure = drawn(built(Sweep(axes, refinements=REFINED.refinements)), "residuals")
    traces = plot(figure)["data"]
    for axis in ("x", "x2"):
        labels = list(dict.fromkeys(one["name"] for one in traces if one["xaxis"] == axis))
        assert labels[0] == BAND
    assert sum(one["showlegend"] for one in traces if one["name"] == BAND) == 1


def test_residual__of_a_value_of_zero_is_none() -> None:
    none_through = fakes.measured(0.0)
    known = {
        point.run.id: replace(fakes.result(point.run), measurements={"hole_diameter": none_through})
        if point.coordinates["speed"] == LONELY
        else fakes.result(point.run)
        for point in REFINED.runs()
    }
    (panel,) = drawn(built(REFINED, known), "residuals").panels
    for series in panel.series:
        answers = dict(zip(series.x, series.y or series.high, strict=True))
        assert answers.get(LONELY) is None


# --- captions ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("sweep", "words"),
    [
        (REFINED, "uncertainty: mesh, scatter over offsets, measurement. Open points"),
        (TWO_GRIDS, "uncertainty: mesh, what one offset cannot see, measurement. Open points"),
        (
            OFFSETS_ALONE,
            "uncertainty: scatter over offsets, measurement, without a part for the mesh. Open points carry a flag.",
        ),
        (PLAIN, "that one run states, without a part for the mesh; open points carry a flag."),
    ],
    ids=["refined", "two grids", "offsets", "plain"],
)
def test_caption__names_the_parts_that_error_bars_have(sweep: Sweep, words: str) -> None:
    assert words in drawn(built(sweep), "laws").caption


def test_caption__counts_points_whose_bar_has_no_part_for_the_mesh() -> None:
    caption = drawn(built(REFINED, without_coarse_runs(REFINED)), "laws").caption
    assert "uncertainty: mesh (unknown at 1 of 6 points), scatter over offsets" in caption


def test_caption__speaks_of_extrapolation_only_where_something_converges() -> None:
    assert "extrapolated where it converges" in drawn(built(REFINED), "laws").caption
    assert "extrapolated" not in drawn(built(TWO_GRIDS), "laws").caption


def test_caption__of_points_without_any_error_bar_names_none() -> None:
    equal = replace(fakes.measured(0.012), parts={}, uncertainty=0.0)
    known = {
        name: replace(one, measurements=dict.fromkeys(one.measurements, equal))
        for name, one in fakes.results(TWO_GRIDS).items()
    }
    dataset = built(TWO_GRIDS, known)
    assert "no uncertainty of theirs is known" in drawn(dataset, "laws").caption
    assert "no point has resolutions that tell" in drawn(dataset, "residuals").caption


# --- marks ------------------------------------------------------------------------------------------


def test_mark__of_a_single_grid_is_open_beside_points_that_converge() -> None:
    speeds = open_speeds(built(REFINED, without_coarse_runs(REFINED)))
    assert LONELY in speeds
    assert 2e3 not in speeds


def test_mark__of_two_grids_is_open() -> None:
    assert open_speeds(built(TWO_GRIDS)) == list(fakes.SPEEDS)


def test_mark__is_filled_where_no_resolutions_were_asked_for() -> None:
    assert open_speeds(built(OFFSETS_ALONE)) == []
