"""The report: the page prints the document, the document says what the cube says, and nothing else."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from studies.cubes import cube
from studies.reports import page, report
from studies.reports.compare import compare
from studies.values.formats import KINDS, display_of, printed, printed_in
from tests.studies.support import fakes
from tests.studies.support.fakes import Axis, Sweep
from tests.studies.support.printed import Page, at, read_page

SWEEPS = {
    "grid": fakes.holes(),
    "craters": fakes.craters(),
    "zip": Sweep(
        (Axis("speed", "m s-1", (2e3, 3e3)), Axis("plate_thickness", "m", (2e-3, 3e-3))),
        combine="zip",
    ),
    "words": Sweep(
        (Axis("projectile", None, ("tin", "lead")),),
        fixed={"projectile_diameter": fakes.DIAMETER, "plate_thickness": 2e-3},
    ),
    "no speed": Sweep(
        (Axis("plate_thickness", "m", (2e-3, 3e-3)), Axis("target.strength.A", "Pa", (9e7, 2e8)))
    ),
    "one run": Sweep((Axis("speed", "m s-1", (5e3,)),)),
    "refined": fakes.refined_holes(),
    "two grids": fakes.refined_holes((16.0, 32.0), (0.0,)),
    "offsets": fakes.refined_holes((16.0,)),
}


def cube_of(case: str) -> xr.Dataset:
    sweep = SWEEPS[case]
    known = fakes.with_trouble(sweep) if case in ("grid", "refined") else fakes.results(sweep)
    none_through = (fakes.observed(5e3, 0.002, 0.0),)  # nothing is relative to it
    shots = {"grid": fakes.SHOTS, "refined": fakes.SHOTS, "one run": none_through}.get(case, ())
    return cube.build(sweep, known, fakes.catalogue(sweep.scenario, shots))


def said_of(dataset: xr.Dataset) -> dict:
    """The document as a program reads it."""
    return json.loads(report.as_json(report.document(dataset, compare(dataset))))


def shown(said: dict) -> Page:
    return read_page(page.page(said))


@pytest.fixture(scope="module", params=SWEEPS)
def case(request: pytest.FixtureRequest) -> tuple[xr.Dataset, dict, Page]:
    dataset = cube_of(request.param)
    said = said_of(dataset)
    return dataset, said, shown(said)


def test_page__every_number_is_the_one_in_the_twin(case: tuple[xr.Dataset, dict, Page]) -> None:
    _, said, seen = case
    numbers = [mark for mark in seen.marks if mark.value is not None]
    assert len(numbers) > 30
    for mark in numbers:
        value = at(said, mark.path)
        assert mark.value == ("" if value is None else json.dumps(value))
        spoken = (
            {printed(value, kind) for kind in KINDS}
            if isinstance(value, float | int | None)
            else {value}
        )
        in_units = {
            printed_in(value, unit)
            for unit in ("m", "m s-1", "s", "Pa", "1")
            if not isinstance(value, str)
        }
        assert mark.text in spoken | in_units


def test_page__every_text_is_the_one_in_the_twin(case: tuple[xr.Dataset, dict, Page]) -> None:
    _, said, seen = case
    texts = [mark for mark in seen.marks if mark.value is None and mark.path != "/provenance/sweep"]
    assert {mark.text == at(said, mark.path) for mark in texts} == {True}


def test_page__has_no_digit_outside_of_what_the_twin_says(
    case: tuple[xr.Dataset, dict, Page],
) -> None:
    _, _, seen = case
    assert re.findall(r"\d", seen.unmarked) == []


def test_page__loads_nothing(case: tuple[xr.Dataset, dict, Page]) -> None:
    _, _, seen = case
    assert all(link.startswith(("#", "data:")) for link in seen.links)


def test_drawings__show_the_points_of_the_twin(case: tuple[xr.Dataset, dict, Page]) -> None:
    _, said, seen = case
    assert len(seen.drawings) == len(said["figures"]) > 0
    for drawing, figure in zip(seen.drawings, said["figures"], strict=True):
        x, y = (display_of(figure[axis]["unit"]).factor for axis in "xy")
        drawn = {(a, b) for t in drawing["data"] for a, b in zip(t["x"], t["y"], strict=True)}
        for series in (one for panel in figure["panels"] for one in panel["series"]):
            for name in ("y", "low", "high"):
                for a, b in zip(
                    series["x"], series[name] or [None] * len(series["x"]), strict=True
                ):
                    if a is not None and b is not None:
                        assert (a if isinstance(a, str) else a * x, b * y) in drawn


def test_runs__have_the_values_of_their_cells(case: tuple[xr.Dataset, dict, Page]) -> None:
    dataset, said, _ = case
    flat = dataset.stack(cell=dataset.run_state.dims)
    assert len(said["runs"]) == dataset.run_state.size
    for number, run in enumerate(said["runs"]):
        cell = flat.isel(cell=number)
        assert run["id"] == cell.run_id.item()
        assert run["reason"] == cell.run_reason.item()
        for name, value in run["values"].items():
            np.testing.assert_equal(np.nan if value is None else value, float(cell[name]))


def test_main_figure__is_what_the_cube_alone_gives() -> None:
    dataset = cube_of("grid")
    figure = said_of(dataset)["figures"][0]
    assert figure["name"] == "hole_diameter_laws"
    ratio = dataset.hole_diameter.where(dataset.run_state == 0) / dataset.equivalent_diameter
    for panel in figure["panels"]:
        (points,) = [series for series in panel["series"] if series["kind"] == "simulation"]
        mine = ratio.sel(panel["at"])
        assert points["x"] == list(mine.speed.values)
        np.testing.assert_array_equal(np.array(points["y"], float), mine.values)


def test_main_figure__band_is_smallest_to_largest_of_the_stated_variants() -> None:
    dataset = cube_of("grid")
    panel = said_of(dataset)["figures"][0]["panels"][1]
    (band,) = [series for series in panel["series"] if series["kind"] == "band"]
    labels = [f"strength_ln/{variant}" for variant in fakes.YIELDS]
    answers = (
        dataset.hole_diameter_by_law.sel(panel["at"]).sel(hole_diameter_law=labels) / fakes.DIAMETER
    )
    assert band["low"] == list(answers.min("hole_diameter_law").values)
    assert band["high"] == list(answers.max("hole_diameter_law").values)


def test_main_figure__a_law_knows_where_it_is_out_of_range() -> None:
    panel = said_of(cube_of("grid"))["figures"][0]["panels"][0]
    (law,) = [series for series in panel["series"] if "aluminium" in series["label"]]
    assert law["in_range"] == [False, True, True, True, False, False]


def test_main_figure__an_observed_shot_stands_in_the_panel_it_belongs_to() -> None:
    panels = said_of(cube_of("grid"))["figures"][0]["panels"]
    seen = [
        (panel["at"]["plate_thickness"], series["x"])
        for panel in panels
        for series in panel["series"]
        if series["kind"] == "observation"
    ]
    assert seen == [(2e-3, [2600.0]), (3e-3, [4000.0, 5930.0]), (4e-3, [9000.0])]


def test_trouble__failed_and_flagged_runs_are_named_with_their_reasons() -> None:
    seen = shown(said_of(cube_of("grid")))
    texts = {mark.text for mark in seen.marks}
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
    dataset.attrs["sweep"] = json.dumps({"fixed": {"name": hostile}})
    dataset.run_reason[:] = hostile
    html = page.page(said_of(dataset))
    assert "<script>alert" not in html
    assert html.count("</script>") == page.page(said_of(cube_of("one run"))).count("</script>")


def test_template__cannot_print_a_number_by_another_way() -> None:
    template = page.environment().from_string("{{ report.n }}")
    with pytest.raises(TypeError, match="without a format"):
        template.render(report=page.Node({"n": 3.5}))


def test_document__has_no_nan_and_goes_through_json() -> None:
    assert "NaN" not in report.as_json(report.document(cube_of("grid"), compare(cube_of("grid"))))


@pytest.mark.parametrize("case", ["one run", "offsets"])
def test_single_grid__is_said_to_judge_nothing(case: str) -> None:
    said = said_of(cube_of(case))
    assert said["mesh"].endswith("so nothing is called inside or outside of it.")
    sentences = [one["sentence"] for one in said["residuals"] if one["reference"] == "simulation"]
    assert len(sentences) > 3
    assert not [one for one in sentences if "inside the error bar" in one]


def test_several_resolutions__are_said_to_have_a_mesh_error() -> None:
    assert "Its error bar joins mesh error, scatter" in said_of(cube_of("refined"))["mesh"]


def test_figure__has_no_band_where_no_error_bar_is_known() -> None:
    sweep = SWEEPS["two grids"]
    equal = replace(fakes.measured(0.012), parts={}, uncertainty=0.0)
    known = {
        name: replace(one, measurements=dict.fromkeys(one.measurements, equal))
        for name, one in fakes.results(sweep).items()
    }
    said = said_of(cube.build(sweep, known, fakes.catalogue()))
    (figure,) = [one for one in said["figures"] if one["name"] == "hole_diameter_convergence"]
    kinds = {series["kind"] for panel in figure["panels"] for series in panel["series"]}
    assert kinds == {"level"}


def test_table_of_residuals__says_how_many_points_lie_inside_the_error_bar() -> None:
    said = said_of(cube_of("refined"))
    marks = {mark.path: mark.text for mark in shown(said).marks}
    judged = [
        (number, group, row[group])
        for number, row in enumerate(said["residuals"])
        for group in ("everywhere", "in_range")
        if row[group] and row[group]["judged"]
    ]
    assert {said["residuals"][number]["reference"] for number, _, _ in judged} == {
        "simulation",
        "observation",
    }
    for number, group, found in judged:
        place = f"/residuals/{number}/{group}"
        assert marks[f"{place}/within"] == printed(found["within"], "count")
        assert marks[f"{place}/judged"] == printed(found["judged"], "count")
        assert marks[f"{place}/bar"] == printed(found["bar"], "length")
        assert marks[f"{place}/relative_bar"] == printed(found["relative_bar"], "share_spread")


@pytest.mark.parametrize("case", ["one run", "offsets"])
def test_table_of_residuals__says_where_the_mesh_error_is_unknown(case: str) -> None:
    said = said_of(cube_of(case))
    seen = shown(said)
    assert "mesh error unknown" in seen.unmarked
    paths = {mark.path for mark in seen.marks}
    for number, row in enumerate(said["residuals"]):
        if row["reference"] == "simulation":
            assert f"/residuals/{number}/everywhere/n" in paths
            assert f"/residuals/{number}/everywhere/within" not in paths


def test_table_of_residuals__keeps_its_columns_under_their_headings() -> None:
    (row,) = re.findall(
        r"<tr><td class=\"word\">[^\n]*maiden_c.*?</tr>",
        page.page(said_of(cube_of("two grids"))),
        re.DOTALL,
    )[:1]
    assert row.count("<td") == 1 + 2 * 6
