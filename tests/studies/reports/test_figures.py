"""Figures of simulation, laws, observations and convergence, and their captions."""

import json
import math
import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.cubes import cube
from studies.cubes.cells import MissingResult
from studies.laws import Shot
from studies.quantities.findings import InvalidInput
from studies.reports import report
from studies.reports.compare import compare
from studies.reports.drawing.charts import chart, draw
from studies.reports.drawing.layout import WIDTHS
from studies.reports.drawing.styles import FLAGGED, NO_MESH_ERROR, OUTSIDE
from studies.reports.figures import ERROR_BAR, Figure, Series, figures
from studies.reports.page import page
from studies.reports.publish import draw_figures
from studies.sweeps.axes import Axis
from studies.sweeps.sweep import Sweep
from tests.rows import at_most, equal
from tests.studies.support import fakes
from tests.studies.support.fakes import sweep_of

REFINED = fakes.refined_holes()
OFFSETS_ALONE = fakes.refined_holes((16.0,))
TWO_GRIDS = fakes.refined_holes((16.0, 32.0), 1)
PLAIN = fakes.holes()
LONELY = 4e3  # the speed at which only the finest resolution has a value, where coarse runs are lost


def built(sweep: Sweep, outcomes: dict[str, Any] | None = None, **catalogue: Any) -> xr.Dataset:
    return cube.build(sweep, outcomes or fakes.results(sweep), fakes.catalogue(**catalogue))


def without_coarse_runs() -> xr.Dataset:
    """A refined sweep with one resolution at one speed."""
    lost = [
        point.run.id
        for point in REFINED.runs()
        if point.coordinates["speed"] == LONELY and point.coordinates["cells_per_diameter"] != fakes.CELLS[-1]
    ]
    crashed = dict.fromkeys(lost, MissingResult("crashed", "out of luck"))
    return built(REFINED, {**fakes.results(REFINED), **crashed})


def drawn(dataset: xr.Dataset, ending: str) -> Figure:
    (entry,) = [figure for figure in figures(dataset, compare(dataset)) if figure.name == f"hole_diameter_{ending}"]
    return entry


def series_of(figure: Figure, panel: int = 0, **wanted: str) -> list[Series]:
    return [
        series
        for series in figure.panels[panel].series
        if all(getattr(series, key) == value for key, value in wanted.items())
    ]


def bands(figure: Figure) -> list[Series]:
    return series_of(figure, label=ERROR_BAR)


def open_speeds(dataset: xr.Dataset) -> list[Any]:
    """Abscissas of the open marks of the simulation."""
    (simulation,) = series_of(drawn(dataset, "laws"), kind="simulation")
    return [x for x, is_open in zip(simulation.x, simulation.flagged, strict=True) if is_open]


# --- simulation, laws and observations ------------------------------------------------------------


@pytest.mark.claim("report", "cube-redoes-figures")
def test_main_figure__is_redone_from_the_cube_alone() -> None:
    """xarray.open_dataset("cube.nc") alone redoes the main figure of the report."""
    dataset = built(PLAIN, fakes.with_trouble(PLAIN))
    ratios = dataset.hole_diameter.where(dataset.run_state == 0) / dataset.equivalent_diameter
    answers = dataset.hole_diameter_by_law / dataset.equivalent_diameter
    variants = answers.sel(hole_diameter_law=[f"strength_ln/{name}" for name in fakes.YIELDS])
    figure = drawn(dataset, "laws")
    for number, panel in enumerate(figure.panels):
        (points,) = series_of(figure, number, kind="simulation")
        assert points.x == fakes.SPEEDS
        np.testing.assert_array_equal(np.array(points.y, float), ratios.sel(panel.at).values)
        (band,) = series_of(figure, number, kind="band")
        mine = variants.sel(panel.at)
        assert band.low == tuple(mine.min("hole_diameter_law").values)
        assert band.high == tuple(mine.max("hole_diameter_law").values)
        (law,) = series_of(figure, number, label="thesis 1-3, aluminium")
        assert law.in_range == (False, True, True, True, False, False)


def test_main_figure__an_observed_shot_stands_in_the_panel_that_it_meets() -> None:
    figure = drawn(built(PLAIN, observations=fakes.SHOTS), "laws")
    shots = [series_of(figure, number, kind="observation") for number in range(3)]
    assert [each[0].x for each in shots] == [(2600.0,), (4000.0, 5930.0), (9000.0,)]


@pytest.mark.parametrize("sweep", [TWO_GRIDS, OFFSETS_ALONE], ids=["two grids", "one grid"])
def test_mark__is_open_where_resolutions_tell_no_mesh_error(sweep: Sweep) -> None:
    assert not open_speeds(built(sweep))
    assert LONELY in open_speeds(without_coarse_runs())


@pytest.mark.parametrize(
    ("sweep", "words"),
    [
        (REFINED, "uncertainty: mesh error, scatter over offsets, measurement. Open points"),
        (TWO_GRIDS, "uncertainty: mesh error, position on the grid (as single runs state it)"),
        (OFFSETS_ALONE, "the mean over offsets, without bars: mesh error unknown."),
        (PLAIN, "Points are runs, without bars: mesh error unknown."),
    ],
    ids=["refined", "two grids", "offsets", "plain"],
)
def test_caption__names_the_parts_that_error_bars_have(sweep: Sweep, words: str) -> None:
    caption = drawn(built(sweep), "laws").caption
    assert words in caption
    assert ("size zero where that is more certain" in caption) == (sweep is REFINED)


def test_caption__counts_points_without_a_mesh_error() -> None:
    dataset = without_coarse_runs()
    assert "mesh error (unknown at 1 of 6 points, without bars), scatter" in drawn(dataset, "laws").caption
    assert "missing at 1 of 6 points, whose mesh error" in drawn(dataset, "residuals").caption


# --- marks, legends and axes ----------------------------------------------------------------------


def legend_of(figure: Figure) -> dict[str, Any]:
    """What stands before each label of the legend, in its order."""
    legend = chart(figure).legends[0]
    labels = [text.get_text().replace("\n", " ") for text in legend.get_texts()]
    return dict(zip(labels, legend.legend_handles, strict=True))


def test_legend__is_open_and_dotted_for_a_law_that_is_nowhere_inside_its_range() -> None:
    dataset = built(PLAIN)
    dataset.hole_diameter_by_law_in_range.loc[{"hole_diameter_law": "maiden_al"}] = 0
    legend = legend_of(drawn(dataset, "laws"))
    looks = {
        name: (handle.get_linestyle(), handle.get_markerfacecolor())
        for name, handle in legend.items()
        if hasattr(handle, "get_markerfacecolor")
    }
    assert looks["thesis 1-3, aluminium"] == looks[OUTSIDE] == (":", "none")
    assert looks["general form with the sound speed"] == ("-", "#d55e00")
    _, dashes = legend["thesis 1-5, all constants"]._dash_pattern  # of the edge of a patch
    assert dashes


def test_legend__has_no_mark_outside_a_range_where_no_law_has_a_value_there() -> None:
    dataset = built(PLAIN)
    values, in_range = dataset.hole_diameter_by_law, dataset.hole_diameter_by_law_in_range
    assert OUTSIDE in legend_of(drawn(dataset, "laws"))
    dataset["hole_diameter_by_law"] = values.where(in_range == 1)
    assert OUTSIDE not in legend_of(drawn(dataset, "laws"))


def test_legend__explains_open_marks_of_values_without_a_mesh_error() -> None:
    legend = legend_of(drawn(without_coarse_runs(), "laws"))
    assert legend[NO_MESH_ERROR].get_markerfacecolor() == "none"
    assert NO_MESH_ERROR not in legend_of(drawn(built(REFINED), "laws"))


def test_flagged_points__are_ringed_with_their_flags_beside_them() -> None:
    dataset = built(PLAIN, fakes.with_trouble(PLAIN))
    last = chart(drawn(dataset, "laws")).axes[2]
    (rings,) = [each for each in last.collections if each.get_sizes().size and each.get_sizes()[0] > 100.0]
    assert rings.get_offsets()[:, 0].tolist() == [2.0]
    assert not rings.get_facecolors().size
    assert "under resolved" in {text.get_text() for text in last.texts}
    assert FLAGGED not in legend_of(drawn(built(PLAIN), "laws"))


def test_axis__is_set_by_the_simulation_and_the_laws_inside_their_range() -> None:
    figure = drawn(built(PLAIN), "laws")
    inside = [
        y
        for panel in figure.panels
        for series in panel.series
        for y, counts in zip(series.y, series.in_range or [True] * len(series.y), strict=False)
        if counts and y is not None
    ]
    beyond = [y for panel in figure.panels for s in panel.series for y in s.high if y is not None]
    low, high = chart(figure).axes[0].get_ylim()
    assert low == 0.0
    assert max(inside) < high < max(beyond)


@pytest.mark.parametrize(("share", "explained"), [(0.1, True), (0.9, False)])
def test_caption_of_growth__explains_a_hole_that_closes_again(share: float, explained: bool) -> None:
    dataset = built(PLAIN)
    history = dataset.hole_diameter_history
    history[(0,) * (history.ndim - 1)] *= np.where(np.arange(history.shape[-1]) % 2, share, 1.0)
    assert ("its last thread" in drawn(dataset, "growth").caption) == explained


def test_axis__is_not_set_by_a_bar_longer_than_its_value() -> None:
    dataset = built(REFINED)
    before = chart(drawn(dataset, "laws")).axes[0].get_ylim()
    bars = dataset.hole_diameter_converged_uncertainty
    bars[(0,) * bars.ndim] = 3.0 * dataset.hole_diameter_converged.max()
    figure = drawn(dataset, "laws")
    assert chart(figure).axes[0].get_ylim() == before
    assert figure.caption.endswith("the frame cuts 1 bar that is longer than its value.")
    assert "the frame" not in drawn(built(REFINED), "laws").caption


def test_axis_of_residuals__has_no_sign_at_zero() -> None:
    axis = chart(drawn(built(PLAIN), "residuals")).axes[0].yaxis
    places = axis.get_majorticklocs()
    texts = dict(zip(places, axis.get_major_formatter().format_ticks(places), strict=True))
    assert texts[0] == "0\u202f%"
    assert all(text[0] in "+−" for value, text in texts.items() if value)


def test_panels__stand_below_each_other_where_the_page_is_narrow() -> None:
    figure = drawn(built(PLAIN), "laws")
    lefts = [{axes.get_position().x0 for axes in chart(figure, width).axes} for width in WIDTHS.values()]
    assert [len(each) for each in lefts] == [3, 1]


# --- residuals ------------------------------------------------------------------------------------


def test_band__is_the_error_bar_over_the_value_about_zero() -> None:
    dataset = built(REFINED)
    figure = drawn(dataset, "residuals")
    (band,) = bands(figure)
    relative = dataset.hole_diameter_converged_uncertainty / dataset.hole_diameter_converged
    assert band.x == fakes.SPEEDS
    np.testing.assert_allclose(np.array(band.high, float), relative.values)
    np.testing.assert_allclose(np.array(band.low, float), -relative.values)
    (law,) = series_of(figure, label="general form with the sound speed")
    inside = np.abs(np.array(law.y, float)) <= np.array(band.high, float)
    (entry,) = [each for each in compare(dataset).residuals if each.subject == "maiden_c"]
    assert 0 < entry.everywhere.within == inside.sum() < entry.everywhere.judged == len(inside)


def test_band__does_not_reach_over_a_point_whose_mesh_error_is_unknown() -> None:
    figure = drawn(without_coarse_runs(), "residuals")
    assert [band.x for band in bands(figure)] == [(2e3, 3e3), (5e3, 6e3, 7e3)]


@pytest.mark.parametrize(
    ("sweep", "reason"),
    [(PLAIN, "every point is one run on one mesh"), (OFFSETS_ALONE, "one resolution")],
    ids=["plain", "offsets"],
)
def test_band__is_absent_without_resolutions_and_the_caption_says_why(sweep: Sweep, reason: str) -> None:
    figure = drawn(built(sweep), "residuals")
    assert bands(figure) == []
    assert reason in figure.caption


def test_band__lies_behind_the_marks() -> None:
    axes = (*REFINED.axes, fakes.Axis("plate_thickness", "m", (2e-3, 3e-3)))
    figure = drawn(built(sweep_of(*axes, resolutions=fakes.CELLS, offsets=fakes.OFFSETS)), "residuals")
    for panel, axes_of_panel in zip(figure.panels, chart(figure).axes, strict=True):
        assert panel.series[0].label == ERROR_BAR
        bands = [each for each in axes_of_panel.collections if each.get_alpha() == 0.2]
        marks = [each for each in axes_of_panel.collections if each not in bands]
        assert bands
        assert max(band.zorder for band in bands) < min(mark.zorder for mark in marks)


def test_residual__of_a_value_of_zero_is_none() -> None:
    held = replace(fakes.measured(0.0), parts={})
    outcomes = {
        point.run.id: replace(fakes.result(point.run), measurements={"hole_diameter": held})
        if point.coordinates["speed"] == LONELY
        else fakes.result(point.run)
        for point in REFINED.runs()
    }
    for series in drawn(built(REFINED, outcomes), "residuals").panels[0].series:
        assert dict(zip(series.x, series.y or series.high, strict=True)).get(LONELY) is None


# --- convergence ----------------------------------------------------------------------------------


def test_convergence__shows_runs_levels_and_the_value_with_its_error_bar() -> None:
    dataset = built(REFINED)
    figure = drawn(dataset, "convergence")
    assert [panel.at["speed"] for panel in figure.panels] == list(fakes.SPEEDS)
    for number, panel in enumerate(figure.panels):
        cell = dataset.sel(panel.at)
        runs = cell.hole_diameter / fakes.DIAMETER
        (level,) = series_of(figure, number, kind="level")
        assert level.x == (1 / 16, 1 / 32, 1 / 64)
        np.testing.assert_allclose(np.array(level.y, float), runs.mean("offset").values)
        half = 0.5 * (runs.max("offset") - runs.min("offset")).values
        np.testing.assert_allclose(np.array(level.uncertainty, float), half)
        (dots,) = series_of(figure, number, kind="run")
        assert sorted(np.array(dots.y, float)) == sorted(runs.values.ravel())
        (band,) = bands(replace(figure, panels=(panel,)))
        value, bar = cell.hole_diameter_converged, cell.hole_diameter_converged_uncertainty
        assert band.low[0] == pytest.approx(float(value - bar) / fakes.DIAMETER)


def test_convergence__extrapolates_only_what_converges_and_says_the_verdict() -> None:
    dataset = built(REFINED)
    figure = drawn(dataset, "convergence")
    for number, panel in enumerate(figure.panels):
        limits = series_of(figure, number, kind="limit")
        trends = series_of(figure, number, kind="trend")
        converging = fakes.VERDICTS[float(panel.at["speed"])] == "converging"
        assert panel.note.startswith(fakes.VERDICTS[float(panel.at["speed"])])
        assert (len(limits), len(trends)) == (converging, converging)
        if converging:
            cell = dataset.sel(panel.at)
            end = float(cell.hole_diameter_converged_extrapolated) / fakes.DIAMETER
            assert (limits[0].x, limits[0].y) == ((0.0,), (end,))
            assert trends[0].y[0] == pytest.approx(end)


def test_convergence__of_offsets_alone_is_not_drawn() -> None:
    dataset = built(OFFSETS_ALONE)
    names = [figure.name for figure in figures(dataset, compare(dataset))]
    assert not [name for name in names if "convergence" in name]


def test_convergence__has_no_band_where_no_error_bar_is_known() -> None:
    equal = replace(fakes.measured(0.012), parts={}, uncertainty=0.0)
    outcomes = {
        name: replace(result, measurements=dict.fromkeys(result.measurements, equal))
        for name, result in fakes.results(TWO_GRIDS).items()
    }
    dataset = built(TWO_GRIDS, outcomes)
    for panel in drawn(dataset, "convergence").panels:
        assert {series.kind for series in panel.series} == {"level"}
    assert "there are no bars: mesh error unknown" in drawn(dataset, "laws").caption
    assert "no point has resolutions that show" in drawn(dataset, "residuals").caption


def constant(value: float, shot: Shot, variant: str) -> float:
    return value


def with_many_laws(*, inside: int) -> xr.Dataset:
    """Holes with nine laws, some of which are inside their range at every point."""
    many = tuple(
        fakes.law(
            f"law_{number}",
            "hole_diameter",
            partial(constant, 1.5 + 0.1 * number),
            range=fakes.within(0.0, math.inf if number < inside else 0.001),
            title=f"law {number}",
        )
        for number in range(9)
    )
    sweep = fakes.holes()
    return cube.build(sweep, fakes.results(sweep), replace(fakes.catalogue(), laws=many))


@pytest.mark.parametrize("inside", [3, 9])
def test_figure__of_many_laws_draws_those_inside_their_range_and_lists_the_others(inside: int) -> None:
    dataset = with_many_laws(inside=inside)
    for name in ("hole_diameter_laws", "hole_diameter_residuals"):
        (drawn,) = [each for each in figures(dataset, compare(dataset)) if each.name == name]
        labels = {one.label for panel in drawn.panels for one in panel.series if one.kind == "law"}
        assert labels == {f"law {number}" for number in range(inside)}
        if name == "hole_diameter_laws":
            listed = ", ".join(f"law {number}" for number in range(inside, 9))
            assert (f"no point is inside their range: {listed}." in drawn.caption) == bool(listed)
        looks = [
            (handle.get_color(), handle.get_linestyle(), handle.get_marker())
            for name, handle in legend_of(drawn).items()
            if name in labels
        ]
        assert len(set(looks)) == len(looks) == inside


def test_legend__says_which_laws_are_drawn_only() -> None:
    laws = tuple(replace(law, confidence="memory") for law in fakes.HOLE_LAWS[:1])
    dataset = cube.build(PLAIN, fakes.results(PLAIN), replace(fakes.catalogue(), laws=laws))
    drawn = figures(dataset, compare(dataset))[0]
    labels = {one.label for panel in drawn.panels for one in panel.series if one.kind == "law"}
    assert labels == {"thesis 1-3, aluminium (drawn only)"}


# ---- what fits -----------------------------------------------------------------------------------


@pytest.mark.parametrize("width", WIDTHS.values())
def test_titles_and_legend__fit_and_part_no_number_from_its_unit(width: float) -> None:
    figure = replace(drawn(built(REFINED), "laws"), scales="own")
    title = "speed 6.18 km/s, plate thickness 2 mm"
    label = "Volume over energy (constant fitted to one copper shot)"
    laws = (replace(series_of(figure, kind="law")[0], label=label),)
    panels = (replace(figure.panels[0], title=title, series=laws, note="converging"),) * 6
    drawing = chart(replace(figure, panels=panels), width)
    boxes = [axes.title.get_window_extent() for axes in drawing.axes]
    frames = [axes.get_window_extent() for axes in drawing.axes]
    assert "6.18\u00a0km/s" in drawing.axes[0].get_title().replace("\n", " ")
    assert all(title.x1 <= frame.x1 + 1.0 for title, frame in zip(boxes, frames, strict=True))
    legend = drawing.legends[0].get_window_extent()
    assert legend.x1 <= width
    assert legend.y1 < min(axes.get_tightbbox().y0 for axes in drawing.axes)
    assert label in legend_of(replace(figure, panels=panels))


def test_caption__names_laws_that_coincide_and_laws_left_out_as_unjudged() -> None:
    values = (1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.8)
    laws = tuple(
        fakes.law(f"law_{number}", "hole_diameter", partial(constant, value), title=f"law {number}")
        for number, value in enumerate(values)
    )
    laws = (replace(laws[0], confidence="memory"), *laws[1:])
    sweep = fakes.holes()
    dataset = cube.build(sweep, fakes.results(sweep), replace(fakes.catalogue(), laws=laws))
    figure = drawn(dataset, "laws")
    assert "The lines of law 5 and law 6 coincide." in figure.caption
    assert figure.caption.count("coincide") == 1
    assert "because in no verdict: law 0." in figure.caption
    assert not series_of(figure, label="law 0 (drawn only)")


def test_companions__leave_out_a_reading_that_repeats_another() -> None:
    dataset = built(PLAIN)
    assert len(drawn(dataset, "companions").panels[0].series) == 2
    dataset["hole_diameter_areal"] = dataset["hole_diameter_areal"].copy(data=dataset["hole_diameter"].values)
    names = {figure.name for figure in figures(dataset, compare(dataset))}
    assert "hole_diameter_companions" not in names


# ---- files ---------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a cube with several figures."""
    folder = tmp_path_factory.mktemp("cube")
    cube.write(built(PLAIN, observations=fakes.SHOTS), folder / "cube.nc")
    return folder


def test_draw_figures__writes_one_file_a_figure_with_its_titles_and_labels(folder: Path, tmp_path: Path) -> None:
    with xr.open_dataset(folder / "cube.nc") as dataset:
        every = figures(dataset, compare(dataset))
    files = draw_figures(folder, tmp_path, "svg")
    assert [file.name for file in files] == [f"{figure.name}.svg" for figure in every]
    for figure, file in zip(every, files, strict=True):
        # Matplotlib writes each text beside its outlines, as a comment.
        texts = set(re.findall(r"<!-- (.*?) -->", file.read_text().replace("\u00a0", " ")))
        panels = {panel.title for panel in figure.panels if panel.title}
        assert panels <= texts, figure.name
        assert any(figure.y.label in text for text in texts), figure.name


@pytest.mark.parametrize("format", ["png", "pdf"])
def test_draw__writes_the_format_of_the_ending(format: str, tmp_path: Path) -> None:
    words = sweep_of(fakes.Axis("projectile", None, ("al-1100-o", "copper-ofhc")))
    dataset = built(words)
    file = draw(figures(dataset, compare(dataset))[0], tmp_path / f"words.{format}")
    assert file.read_bytes()[:5] in (b"\x89PNG\r", b"%PDF-")
    assert len(list(tmp_path.iterdir())) == 1


def test_draw_figures__of_another_file_says_that_it_is_no_cube(tmp_path: Path) -> None:
    (tmp_path / "cube.nc").write_text("no")
    with pytest.raises(InvalidInput, match="a cube of whipple"):
        draw_figures(tmp_path, tmp_path, "png")


# ---- many runs -----------------------------------------------------------------------------------

MANY, LARGEST = (50, 40), 3e6  # runs over two axes; bytes of their page


@pytest.mark.claim("door", "two-thousand-runs")
@pytest.mark.parametrize("combine", ["grid", "zip"])
def test_two_thousand_runs__have_maps_over_two_axes_and_a_small_page(
    combine: Any, compared: Callable[..., None]
) -> None:
    """Two thousand runs over two axes are maps, each point in its place, on a page below 3 MB."""
    rng = np.random.default_rng(1)
    count = math.prod(MANY)
    along = [np.linspace(0.0, 1.0, each) for each in MANY] if combine == "grid" else rng.random((2, count))
    speed = Axis("speed", "m s-1", tuple((2e3 + 5e3 * along[0]).tolist()))
    thickness = Axis("plate_thickness", "m", tuple((1e-3 + 4e-3 * along[1]).tolist()))
    dataset = built(sweep_of(speed, thickness, combine=combine))
    document = report.document(dataset, compare(dataset))
    names = [figure["name"] for figure in document["figures"]]
    compared(
        equal(
            "figures", expected=["hole_diameter_map", "hole_diameter_residuals_map", "hole_diameter_growth"], got=names
        )
    )
    (panel,) = document["figures"][0]["panels"]
    (series,) = panel["series"]
    compared(equal("points of the map", expected=count, got=len({*zip(series["x"], series["y"], strict=True)})))
    ratios = (dataset.hole_diameter / dataset.equivalent_diameter).values.ravel()
    np.testing.assert_allclose(series["z"], ratios)
    compared(at_most("bytes of the page", limit=LARGEST, got=len(page(json.loads(report.as_json(document))).encode())))
