"""The report: the page prints the document, the document says what the cube says, and nothing else."""

import csv
import json
import re
from dataclasses import fields, replace
from functools import cache
from html import unescape as html_unescape
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from solver.steppers import methods
from studies.cubes.exports import runs_csv
from studies.quantities.display import (
    KINDS,
    MESH_UNKNOWN,
    digits,
    display_of,
    printed,
    printed_alone,
    printed_beside,
    printed_in,
)
from studies.reports import page, report
from studies.reports.document import Head
from studies.reports.drawing.charts import chart
from studies.reports.section import sections
from studies.sweeps.axes import Axis
from tests.studies.support import fakes
from tests.studies.support.fakes import sweep_of
from tests.studies.support.printed import Page, at, read_page, undrawn, undrawn_page

SWEEPS = {
    "grid": fakes.holes(),
    "zip": sweep_of(Axis("speed", "m s-1", (2e3, 3e3)), Axis("plate_thickness", "m", (2e-3, 3e-3)), combine="zip"),
    "words": sweep_of(Axis("projectile", None, ("al-1100-o", "copper-ofhc"))),
    "one run": sweep_of(Axis("speed", "m s-1", (5e3,))),
    "refined": fakes.refined_holes(),
    "offsets": fakes.refined_holes((16.0,)),
}
if "sph" in methods():
    SWEEPS["methods"] = sweep_of(fakes.METHODS, Axis("speed", "m s-1", (2e3, 3e3)), fixed=fakes.BY_BOTH)
DRAWN = ("grid", "words")  # with numbers on the axes, and with words
Case = tuple[xr.Dataset, dict, Page]


def cube_of(case: str) -> xr.Dataset:
    sweep = SWEEPS[case]
    outcomes = fakes.with_trouble(sweep) if case in ("grid", "refined") else fakes.results(sweep)
    none_through = (fakes.observed(5e3, 0.002, 0.0),)  # nothing is relative to it
    shots = {"grid": fakes.SHOTS, "refined": fakes.SHOTS, "one run": none_through}.get(case, ())
    return fakes.cube_of(sweep, outcomes, observations=shots)


@cache
def made(case: str) -> tuple[xr.Dataset, dict, str]:
    """Cube, document and page of a case."""
    dataset = cube_of(case)
    document = fakes.document_of(dataset)
    return dataset, document, page.page(document) if case in DRAWN else undrawn_page(document)


@cache
def appended(case: str) -> str:
    """The appendix of a case, without figures."""
    with undrawn():
        return page.appendix(made(case)[1])


def test_document__has_each_of_its_keys_described() -> None:
    rows = (Path(__file__).parents[3] / "docs" / "report.md").read_text("utf-8")
    _, _, table = rows.partition("## report.json")
    first_cells = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    described = re.findall("`(.+?)`", " ".join(first_cells))
    head = {field.name for field in fields(Head)}
    assert sorted(described) == sorted(head | {section.name for section in sections()})


@pytest.fixture(scope="module", params=SWEEPS)
def case(request: pytest.FixtureRequest) -> Case:
    dataset, document, html = made(request.param)
    return dataset, document, read_page(html)


@pytest.fixture(scope="module", params=["page", "appendix"])
def shown(request: pytest.FixtureRequest, case: Case) -> Page:
    """The page or the appendix of a case."""
    _, document, shown = case
    if request.param == "page":
        return shown
    with undrawn():
        return read_page(page.appendix(document))


@pytest.mark.claim("report", "html-json-cube")
def test_pages__every_number_is_the_one_in_the_document(case: Case, shown: Page) -> None:
    """Every number in the HTML of report and appendix equals the one in report.json."""
    _, document, _ = case
    numbers = [mark for mark in shown.marks if mark.value is not None]
    assert len(numbers) > 30
    for mark in numbers:
        value = at(document, mark.path)
        assert mark.value == ("" if value is None else json.dumps(value))
        if isinstance(value, str):
            assert mark.text == value
        else:
            kinds = {printed(value, kind) for kind in KINDS}
            units = {
                print_in(value, unit)
                for unit in ("m", "m s-1", "s", "Pa", "1")
                for print_in in (printed_in, printed_alone)
            }
            beside = at(document, mark.path.rpartition("/")[0])
            bars = list(beside.values()) if isinstance(beside, dict) else []
            rounded = {
                printed_beside(value, kind, bar)
                for bar in bars
                if isinstance(bar, float)
                for kind in ("ratio", "m3", "kg", "J", "K")
            }
            assert mark.text in kinds | units | rounded


def test_pages__every_text_is_the_one_in_the_document(case: Case, shown: Page) -> None:
    _, document, _ = case
    texts = [mark for mark in shown.marks if mark.value is None]
    printed_texts = [mark for mark in texts if mark.path != "/provenance/sweep"]
    assert {mark.text == at(document, mark.path) for mark in printed_texts} == {True}


@pytest.mark.parametrize("taken", [section.name for section in sections()])
def test_report__is_made_without_any_one_of_its_sections(taken: str, monkeypatch: pytest.MonkeyPatch) -> None:
    left = tuple(section for section in sections() if section.name != taken)
    for module in (report, page):
        monkeypatch.setattr(module, "sections", lambda: left)
    document = fakes.document_of(made("grid")[0])
    assert taken not in document
    with undrawn():
        assert document["headline"] in html_unescape(page.page(document))
        assert page.appendix(document)


def test_report__is_made_where_the_feature_of_its_scenario_is_gone() -> None:
    cube = fakes.cube_of(fakes.holes())
    sweep = {**json.loads(cube.attrs["sweep"]), "scenario": "gone"}
    document = fakes.document_of(cube.assign_attrs(scenario="gone", sweep=json.dumps(sweep)))
    assert document["headline"]
    assert not document["setup"]["doubts"]


def test_pages__have_no_digit_of_their_own_and_load_nothing(shown: Page) -> None:
    assert re.findall(r"\d", shown.unmarked) == []
    beside = ("appendix.html", "report.html", "report.json")
    assert all(link.startswith(("#", "data:")) or link in beside for link in shown.links)


def test_drawings__show_the_points_of_the_document(case: Case) -> None:
    dataset, document, shown = case
    assert document["figures"]
    assert bool(shown.says) == any(dataset is made(name)[0] for name in DRAWN)
    for figure in page.FIGURES.validate_python(document["figures"]):
        factors = np.array([display_of(scale.unit).factor for scale in (figure.x, figure.y)])
        words = list(dict.fromkeys(x for panel in figure.panels for each in panel.series for x in each.x))
        # The first screen has two panels.
        on_page = {"page": len(figure.panels), "ratio": 2, "appendix": 0}[figure.where]
        for place, (panel, axes) in enumerate(zip(figure.panels, chart(figure).axes, strict=True)):
            paths = [path.vertices for each in axes.collections for path in each.get_paths()]
            drawn = {
                tuple(each)
                for each in np.concatenate(
                    [
                        *paths,
                        *(each.get_offsets() for each in axes.collections),
                        *(line.get_xydata() for line in axes.lines),
                    ]
                )
            }
            for series in panel.series:
                for values in (series.y, series.low, series.high):
                    for x, y in zip(series.x, values, strict=False):
                        if x is not None and y is not None:
                            at = (words.index(x) / factors[0] if isinstance(x, str) else x, y)
                            assert tuple(np.array(at, float) * factors) in drawn
                        if y is not None and series.kind == "simulation" and shown.says and place < on_page:
                            says = digits(y * factors[1])
                            assert any(text.startswith(series.label) and says in text for text in shown.says)


@pytest.mark.claim("report", "html-json-cube")
def test_runs__have_the_values_of_their_cells(case: Case) -> None:
    """Every number of a run in report.json equals the one in the cube."""
    dataset, document, _ = case
    flat = dataset.stack(cell=dataset.run_state.dims)
    assert len(document["runs"]["runs"]) == dataset.run_state.size
    for number, run in enumerate(document["runs"]["runs"]):
        cell = flat.isel(cell=number)
        assert run["id"] == cell.run_id.item()
        assert run["reason"] == cell.run_reason.item()
        for name, value in run["values"].items():
            np.testing.assert_equal(np.nan if value is None else value, float(cell[name]))


@pytest.mark.claim("cube", "failed-run-is-a-result")
def test_failed_and_flagged_runs__are_named_with_their_reasons() -> None:
    """A run that fails is in the report with its reason."""
    texts = {mark.text for mark in read_page(appended("grid")).marks}
    assert {
        "density = 3e4 at particle 17 of 'target', t = 1.2e-06 s, step 88",
        "cancelled by its user",
        "under resolved",
        "hole diameter: not perforated",
    } <= texts


def test_text_of_a_user__cannot_become_markup() -> None:
    dataset = cube_of("one run")
    hostile = "<script>alert(1)</script></script><b>&"
    dataset.attrs["title"] = hostile
    dataset.attrs["sweep"] = json.dumps({**json.loads(dataset.attrs["sweep"]), "title": hostile})
    dataset.run_reason[:] = hostile
    document = fakes.document_of(dataset)
    for html in (page.page(document), page.appendix(document)):
        assert "<script>alert" not in html
        assert html.count("</script>") == made("one run")[2].count("</script>")


def test_shot_above_a_bound__is_listed_and_compared_with_nothing() -> None:
    shots = [
        replace(fakes.observed(2e3, 2e-3, 0.0, None), value=None, bounds=bounds)
        for bounds in ((0.0183, None), (None, 0.0179))
    ]
    document = fakes.document_of(fakes.cube_of(SWEEPS["zip"], observations=shots))
    assert [(each["value"], each["lower"], each["upper"]) for each in document["laws"]["own_shots"]] == [
        (None, 0.0183, None),
        (None, None, 0.0179),
    ]
    assert not [each for each in document["laws"]["judgements"] if each["reference"] == "observation"]
    with undrawn():
        html = page.appendix(document)
    assert re.search("&gt; <data [^>]*>18.30<", html)
    assert re.search("&lt; <data [^>]*>17.90<", html)


@pytest.mark.claim("mend-again", "no-bar-of-a-single-grid")
@pytest.mark.parametrize("case", ["one run", "offsets"])
def test_single_grid__has_no_error_bar_wherever_its_number_is_printed(case: str) -> None:
    """No number of a single grid is printed with an error bar: page, report.json, figures and runs.csv have none."""
    dataset, document, html = made(case)
    for values in document["values"]["ranges"]:
        assert values["smallest_uncertainty"] is values["largest_uncertainty"] is None
    for shot in document["laws"]["own_shots"]:
        assert shot["simulation_uncertainty"] is None
    for figure in document["figures"]:
        for series in (each for panel in figure["panels"] for each in panel["series"]):
            if series["kind"] in ("simulation", "quantity"):
                assert {*series["uncertainty"], *series["outer"]} == {None}, figure["name"]
    for quantity in document["convergence"]["quantities"]:
        assert {point["uncertainty"] for point in quantity["points"]} == {None}
    values = re.findall("<dl>.*?</dl>", html.partition('id="values"')[2], re.DOTALL)[0]
    assert f"({MESH_UNKNOWN})" in values
    assert "±" not in values
    assert f"each on one grid: {MESH_UNKNOWN}" in appended(case)
    rows = list(csv.DictReader(runs_csv(dataset, every_column=True).splitlines()))
    stated = [name for name in rows[0] if "uncert" in name and any(row[name] for row in rows)]
    assert stated
    assert all("_reading_uncertainty" in name or "_uncertainty_" in name for name in stated)
