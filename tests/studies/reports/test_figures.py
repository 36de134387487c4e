"""Figures of simulation, laws, observations and convergence, and their captions."""

import math
import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from studies.cubes import cube
from studies.cubes.opening import whole_cube
from studies.cubes.points import main_quantities
from studies.reports import report
from studies.reports.compare import compare
from studies.reports.figure import ERROR_BAR, Figure, Series
from studies.reports.figures import figures, of_runs
from studies.reports.judgement import nearest
from studies.reports.page import appendix, page
from studies.reports.publish import draw_figures
from studies.reports.records import Outcome
from studies.sweeps.axes import Axis
from tests.claims.rows import Row, at_most, equal
from tests.studies.support import fakes
from tests.studies.support.fakes import sweep_of

REFINED = fakes.refined_holes()
PLAIN = fakes.holes()


def drawn(dataset: xr.Dataset, ending: str) -> Figure:
    comparison = compare(dataset)
    every = [*figures(comparison, main_quantities(comparison.points)), *of_runs(dataset, comparison)]
    (entry,) = [figure for figure in every if figure.name == f"hole_diameter_{ending}"]
    return entry


def series_of(figure: Figure, panel: int = 0, **wanted: str) -> list[Series]:
    return [
        series
        for series in figure.panels[panel].series
        if all(getattr(series, key) == value for key, value in wanted.items())
    ]


# --- simulation, laws and observations ------------------------------------------------------------


@pytest.mark.claim("report", "cube-redoes-figures")
def test_main_figure__is_redone_from_the_cube_alone() -> None:
    """The variables of a cube alone redo the main figure of the report, in millimetres and in diameters."""
    dataset = fakes.cube_of(PLAIN, fakes.with_trouble(PLAIN))
    holes = dataset.hole_diameter.where(dataset.run_state == 0)
    for ending, divisor in (("laws", 1.0), ("laws_ratio", dataset.equivalent_diameter)):
        figure = drawn(dataset, ending)
        for number, panel in enumerate(figure.panels):
            (points,) = series_of(figure, number, kind="simulation")
            assert points.x == fakes.SPEEDS
            np.testing.assert_array_equal(np.array(points.y, float), (holes / divisor).sel(panel.at).values)
            (law,) = series_of(figure, number, label="thesis 1-3")
            answers = dataset.hole_diameter_by_law.sel(hole_diameter_law="maiden_al") / divisor
            np.testing.assert_array_equal(np.array(law.y, float), answers.sel(panel.at).values)
            assert law.in_range == (False, True, True, True, False, False)


def test_main_figure__has_two_laws_in_colour_and_every_measured_shot_a_range_too() -> None:
    shots = [
        fakes.observed(4e3, 3e-3, 17.9e-3),
        replace(fakes.observed(6e3, 3e-3, 0.0, None), value=None, bounds=(21e-3, 24e-3)),
    ]
    dataset = fakes.cube_of(PLAIN, observations=shots)
    figure = drawn(dataset, "laws")
    laws = series_of(figure, 1, kind="law")
    near = nearest(compare(dataset).judgements, "simulation")
    assert [law.label for law in laws if not law.muted] == [law.name for law in reversed(near[:2])]
    (measured,) = series_of(figure, 1, kind="observation")
    assert [*zip(measured.x, measured.y, measured.low, measured.high, strict=True)] == [
        (4e3, 17.9e-3, None, None),
        (6e3, None, 21e-3, 24e-3),
    ]


def test_bars__are_of_mesh_and_reading_inside_and_with_models_outside() -> None:
    dataset = fakes.cube_of(REFINED)
    (points,) = series_of(drawn(dataset, "laws"), kind="simulation")
    inner = dataset.hole_diameter_converged_uncertainty.where(
        np.isfinite(dataset.hole_diameter_converged_uncertainty_mesh)
    )
    models = dataset.hole_diameter_model_part.isel(cells_per_diameter=-1, offset=0)
    parts = [inner, models, dataset.hole_diameter_definition_part]
    outer = np.sqrt(sum(part.fillna(0.0) ** 2 for part in parts)).where(np.isfinite(inner))
    np.testing.assert_array_equal(np.array(points.uncertainty, float), inner.values)
    np.testing.assert_allclose(np.array(points.outer, float), outer.values)


@pytest.mark.claim("report", "drawn-bars")
def test_law__is_called_within_the_bars_where_it_is_drawn_inside_of_them_and_nowhere_else(
    compared: Callable[[Row], None],
) -> None:
    """A law is within its bars where its line crosses the drawn bar with models, its own scatter added."""
    dataset = fakes.cube_of(REFINED)
    (points,) = series_of(drawn(dataset, "laws"), kind="simulation")
    lines = {law.label: law for law in series_of(drawn(dataset, "laws"), kind="law")}
    scatter = dict(
        zip(dataset.hole_diameter_law.values.tolist(), dataset.hole_diameter_law_scatter.values.tolist(), strict=True)
    )
    called: set[str] = set()
    for judged in compare(dataset).judgements:
        seen = []
        for at in judged.points:
            place = points.x.index(at.at["speed"])
            law, value, bar = lines[judged.name].y[place], points.y[place], points.outer[place]
            if at.outcome is not Outcome.NOT_COMPARABLE and law and value and bar:
                spread = scatter[judged.law]
                reach = math.hypot(bar, law * (0.0 if math.isnan(spread) else spread))
                side = Outcome.WITHIN if abs(law - value) <= reach else Outcome.LOW if law < value else Outcome.HIGH
                seen.append((at.outcome, side))
        called.update(outcome for outcome, _ in seen)
        if seen:
            compared(
                equal(f"{judged.name}: calls that differ", expected=0, got=sum(one is not two for one, two in seen))
            )
    is_both = Outcome.WITHIN in called and len(called) > 1
    compared(Row("outcomes seen", "within and another", ", ".join(sorted(called)), is_both))


# --- convergence ----------------------------------------------------------------------------------


def test_convergence__shows_runs_levels_error_bars_and_extrapolates_only_what_converges() -> None:
    dataset = fakes.cube_of(REFINED)
    figure = drawn(dataset, "convergence")
    assert [panel.at["speed"] for panel in figure.panels] == list(fakes.SPEEDS)
    for number, panel in enumerate(figure.panels):
        cell = dataset.sel(panel.at)
        runs = cell.hole_diameter
        (level,) = series_of(figure, number, kind="level")
        assert level.x == (1 / 16, 1 / 32, 1 / 64)
        np.testing.assert_allclose(np.array(level.y, float), runs.mean("offset").values)
        np.testing.assert_allclose(np.array(level.uncertainty, float), runs.std("offset", ddof=1).values)
        (dots,) = series_of(figure, number, kind="run")
        assert sorted(np.array(dots.y, float)) == sorted(runs.values.ravel())
        (band,) = series_of(figure, number, label=ERROR_BAR)
        value, bar = cell.hole_diameter_converged, cell.hole_diameter_converged_uncertainty
        assert band.low[0] == pytest.approx(float(value - bar))
        verdict = fakes.VERDICTS[float(panel.at["speed"])]
        assert panel.note.startswith(verdict)
        limits, trends = (series_of(figure, number, kind=kind) for kind in ("limit", "trend"))
        assert len(limits) == len(trends) == (verdict == "converging")
        for limit, trend in zip(limits, trends, strict=True):
            end = float(cell.hole_diameter_converged_extrapolated)
            assert (limit.x, limit.y) == ((0.0,), (end,))
            assert trend.y[0] == pytest.approx(end)


# ---- files ---------------------------------------------------------------------------------------


def test_draw_figures__writes_one_file_a_figure_with_its_titles_and_labels(tmp_path: Path) -> None:
    folder = cube.write(fakes.cube_of(PLAIN, observations=fakes.SHOTS), tmp_path / "cube.nc").parent
    every = report.report_of(whole_cube(folder)).head.figures
    out = tmp_path / "figures"
    out.mkdir()
    files = draw_figures(folder, out, "svg")
    assert [file.name for file in files] == [f"{figure.name}.svg" for figure in every]
    for figure, file in zip(every, files, strict=True):
        # Matplotlib writes each text beside its outlines, as a comment.
        texts = set(re.findall(r"<!-- (.*?) -->", file.read_text().replace("\u00a0", " ")))
        panels = {panel.title for panel in figure.panels if panel.title}
        assert panels <= texts, figure.name
        assert any(figure.y.label in text for text in texts), figure.name


# ---- many runs -----------------------------------------------------------------------------------

MANY, LARGEST, LARGEST_APPENDIX = (50, 40), 3e6, 5e6  # runs over two axes; bytes of their pages


@pytest.mark.claim("door", "two-thousand-runs", minutes=0.2)
@pytest.mark.parametrize("combine", ["grid", "zip"])
def test_two_thousand_runs__have_maps_over_two_axes_and_a_small_page(
    combine: Any, compared: Callable[..., None]
) -> None:
    """Two thousand runs over two axes are maps, each point in its place; page and appendix stay below 3 and 5 MB."""
    rng = np.random.default_rng(1)
    count = math.prod(MANY)
    along = [np.linspace(0.0, 1.0, each) for each in MANY] if combine == "grid" else rng.random((2, count))
    speed = Axis("speed", "m s-1", tuple((2e3 + 5e3 * along[0]).tolist()))
    thickness = Axis("plate_thickness", "m", tuple((1e-3 + 4e-3 * along[1]).tolist()))
    dataset = fakes.cube_of(sweep_of(speed, thickness, combine=combine))
    document = fakes.document_of(dataset)
    names = [figure["name"] for figure in document["figures"]]
    compared(
        equal("figures", expected=["hole_diameter_map", "hole_diameter_laws_map", "hole_diameter_growth"], got=names)
    )
    (panel,) = document["figures"][0]["panels"]
    (series,) = panel["series"]
    compared(equal("points of the map", expected=count, got=len({*zip(series["x"], series["y"], strict=True)})))
    np.testing.assert_allclose(series["z"], dataset.hole_diameter.values.ravel())
    for name, limit, made in (("page", LARGEST, page), ("appendix", LARGEST_APPENDIX, appendix)):
        compared(at_most(f"bytes of the {name}", limit=limit, got=len(made(document).encode())))
