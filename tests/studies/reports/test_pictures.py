"""Pictures of runs in a report: from stored sections, with what they measure; and words where there are none."""

import base64
import io
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from studies.films.section import END, Section, Sections, read_sections
from studies.quantities.display import printed
from studies.quantities.parameters import Parameter
from studies.reports import page
from studies.reports.drawing.pixels import coloured, colours, nearest
from studies.reports.drawing.sketches import setup_sketch
from studies.reports.pictures import MOST_FULL, MOST_RUNS, Frame
from studies.reports.publish import publish_sweep
from studies.reports.setup import upward
from studies.sweeps.axes import Axis
from studies.sweeps.sweep import Sweep
from tests.studies.runs.solved import solved
from tests.studies.support import fakes
from tests.studies.support.fakes import sweep_of

MOST_BYTES = 8 << 20  # of a report
Reported = tuple[dict, str]


def reported(sweep: Sweep, folder: Path, sections: dict[str, Path]) -> Reported:
    files = publish_sweep(sweep, fakes.results(sweep), folder, fakes.catalogue(sweep.scenario), sections)
    document = json.loads(Path(files["report.json"]).read_text())
    return document, Path(files["report.html"]).read_text()


def pictures_of_run(document: dict, number: int) -> list[dict]:
    return document["pictures"]["runs"][number]["pictures"]


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Reported:
    """A run with sections, one with a torn file, one without, and one that failed."""
    folder = tmp_path_factory.mktemp("report")
    sweep = sweep_of(Axis("speed", "m s-1", (2e3, 3e3, 4e3)))
    file = solved("thin_plate") / "sections.npz"
    torn = folder / "torn.npz"
    torn.write_bytes(file.read_bytes()[:1000])
    first, second, _ = (point.run.id for point in sweep.runs())
    return reported(sweep, folder / "out", {first: file, second: torn})


def test_picture__says_what_was_measured_and_when(report: Reported) -> None:
    document, html = report
    [end] = [p for p in pictures_of_run(document, 0) if p["kind"] == "end" and p["field"] == "plastic_strain"]
    hole = document["runs"][0]["values"]["hole_diameter"]
    assert end["across"] == [{"quantity": "hole_diameter", "label": "hole diameter", "value": hole}]
    assert f"hole diameter {printed(hole, 'length')} mm" in end["alt"]
    assert end["alt"] in html
    assert re.search(rf">{printed(hole, 'length')} mm</text>", html)
    sections = read_sections(solved("thin_plate") / "sections.npz")
    state = sections.at(END)
    assert state
    assert end["time"] == state.time


def test_picture__that_is_missing_leaves_its_reason(report: Reported) -> None:
    document, html = report
    torn, absent = (document["pictures"]["runs"][number]["missing"] for number in (1, 2))
    assert "cannot be read" in torn
    assert "no section was kept" in absent
    late = [picture["missing"] for picture in pictures_of_run(document, 0) if picture["missing"]]
    assert len(late) == 1
    assert "the run ended before" in late[0]
    for reason in (torn, absent, *late):
        assert reason in html


def test_run__in_full_size_shows_every_field(report: Reported) -> None:
    document, _ = report
    shown = document["pictures"]["runs"][0]
    assert shown["full"]
    fields = [picture["field"] for picture in shown["pictures"] if picture["kind"] == "end"]
    assert fields == ["plastic_strain", "temperature", "pressure", "density", "speed"]


def test_pictures__of_many_runs_are_of_some_and_the_report_stays_small(tmp_path: Path) -> None:
    sweep = fakes.refined_holes()
    file = solved("thin_plate") / "sections.npz"
    document, html = reported(sweep, tmp_path, {p.run.id: file for p in sweep.runs()})
    runs = document["pictures"]["runs"]
    assert len(sweep.runs()) > MOST_RUNS >= len(runs)
    assert document["pictures"]["left_out"] == len(sweep.runs()) - len(runs)
    finest = max(fakes.CELLS)
    assert {document["runs"][run["run"]]["at"]["cells_per_diameter"] for run in runs} == {finest}
    assert sum(run["full"] for run in runs) == MOST_FULL
    assert len(html.encode()) < MOST_BYTES


def test_page__embeds_pictures_that_can_be_opened(report: Reported) -> None:
    _, html = report
    runs = re.findall(r'<svg class="picture of-run.*?</svg>', html, re.DOTALL)
    # The end with which the page opens; thumbnails of the end and of one moment; five fields and that moment in full.
    assert len(runs) == 1 + 2 + 5 + 1
    for drawn in runs:
        embedded = re.findall(r'href="data:image/png;base64,([^"]+)"', drawn)
        assert len(embedded) == (1 if "thumbnail" in drawn else 2)  # with a colour bar
        shown = np.asarray(Image.open(io.BytesIO(base64.b64decode(embedded[0]))).convert("RGBA"))
        assert 0.0 < (shown[..., 3] > 0).mean() < 1.0
        np.testing.assert_array_equal(shown, shown[:, ::-1])  # the mirror image


def bar(*, mirrored: bool = True) -> tuple[Sections, Section]:
    """A square of 2 by 2 mm beside the axis, its temperature growing along it."""
    at = (np.arange(10) + 0.5) * 2e-4
    position = np.stack([place.ravel() for place in np.meshgrid(at, at)], axis=-1)
    state = Section(0.0, END, position, np.zeros(100, int), {"temperature": position[:, 1]})
    return Sections(("bar",), np.full((1, 2), 2e-4), mirrored, (), (state,)), state


def test_raster__has_matter_to_half_a_width_from_its_particles() -> None:
    sections, state = bar()
    particles = nearest(sections, state, Frame(-4e-3, 4e-3, -1e-3, 3e-3), 400)
    rows, columns = np.nonzero(particles >= 0)
    pixel = 8e-3 / 400
    assert columns.min() * pixel == pytest.approx(2e-3, abs=2 * pixel)
    assert (columns.max() + 1) * pixel == pytest.approx(6e-3, abs=2 * pixel)
    assert rows.min() * pixel == pytest.approx(1e-3, abs=2 * pixel)
    assert (rows.max() + 1) * pixel == pytest.approx(3e-3, abs=2 * pixel)
    assert (particles[rows.min() + 2 : rows.max() - 2, columns.min() + 2 : columns.max() - 2] >= 0).all()


def test_raster__without_a_mirror_has_one_side_alone() -> None:
    sections, state = bar(mirrored=False)
    particles = nearest(sections, state, Frame(-4e-3, 4e-3, -1e-3, 3e-3), 400)
    assert (particles[:, :195] < 0).all()
    assert (particles >= 0).any()


def test_pixels__have_colours_between_the_limits_and_are_clear_elsewhere() -> None:
    values = np.array([-1.0, 0.5, 2.0, np.nan])
    low, middle, high, unknown, nothing = coloured(np.array([[0, 1, 2, 3, -1]]), values, (0.0, 1.0), "pressure")[0]
    for shown, share in ((low, 0.0), (middle, 0.5), (high, 1.0)):
        np.testing.assert_allclose(shown, 255.0 * np.array(colours("pressure")(share)), atol=1.0)
    assert len(set(unknown[:3])) == 1
    assert nothing[3] == 0 != unknown[3]


def test_page__of_a_report_without_sections_says_so_for_each_run(tmp_path: Path) -> None:
    document, html = reported(fakes.holes(), tmp_path, {})
    runs = document["pictures"]["runs"]
    assert {run["missing"] for run in runs} == {"no picture: no section was kept with this run"}
    assert html == page.page(document)


def test_setup__is_to_scale_with_the_values_of_the_sweep(tmp_path: Path) -> None:
    sweep = fakes.holes(fixed={"plate_radius": 28e-3})
    catalogue = fakes.catalogue()
    catalogue = replace(catalogue, parameters={**catalogue.parameters, **fakes.declared_of("plate_radius")})
    files = publish_sweep(sweep, fakes.results(sweep), tmp_path, catalogue)
    setup = json.loads(Path(files["report.json"]).read_text())["pictures"]["setup"]
    assert setup["labels"] == {
        "projectile_diameter": "8 mm",
        "plate_thickness": "2 to 4 mm",
        "plate_radius": "28 mm",
        "speed": "2 to 7 km/s",
    }
    html = Path(files["report.html"]).read_text()
    (disc, _), (wide, high) = (size_of(body, html) for body in ("projectile", "target"))
    assert disc / wide == pytest.approx(8 / 56, rel=0.01)
    assert high / wide == pytest.approx(2 / 56, rel=0.03)


def size_of(body: str, html: str) -> np.ndarray:
    """Width and height of the outline of a body in the sketch."""
    outlines = re.findall(rf'<g class="{body}"> *<path d="([^"]*)"', html)
    return np.ptp(np.array(re.findall(r"(-?[\d.]+) (-?[\d.]+)", outlines[0]), float), axis=0)


def test_growth__shades_the_window_in_which_it_is_judged(tmp_path: Path) -> None:
    sweep = sweep_of(Axis("speed", "m s-1", (2e3, 3e3)))
    sweep = replace(sweep, fixed={**sweep.fixed, "settled_window": 5e-6})
    catalogue = fakes.catalogue()
    window = Parameter(name="settled_window", kind="quantity", unit="s", meaning="window")
    catalogue = replace(catalogue, parameters={**catalogue.parameters, window.name: window})
    file = solved("thin_plate") / "sections.npz"
    sections = {point.run.id: file for point in sweep.runs()}
    files = publish_sweep(sweep, fakes.results(sweep), tmp_path, catalogue, sections)
    report = json.loads(Path(files["report.json"]).read_text())
    [growth, _] = [run["growth"] for run in report["pictures"]["runs"]]
    assert growth["window"] == pytest.approx([35e-6, 40e-6])
    # The figure of all runs has the same window, over each line.
    (figure,) = [each for each in report["figures"] if each["name"] == "hole_diameter_growth"]
    assert [each["window"] for each in figure["panels"][0]["series"]] == [growth["window"]] * 2
    html = Path(files["report.html"]).read_text()
    shades = re.findall(r'<g class="shade"> *<path d="([^"]*)"', html)
    assert len(shades) == 2 * 2 + 2  # each width of the figure, and each run
    for drawn in re.findall(r'<svg class="picture full growth".*?</svg>', html, re.DOTALL):
        ticks = dict(re.findall(r'x="([\d.]+)"[^>]*>(\d+)</text>', drawn.partition("time (")[0]))
        at = {int(time): float(x) for x, time in ticks.items()}
        (shade,) = re.findall(r'<g class="shade"> *<path d="([^"]*)"', drawn)
        x = np.array(re.findall(r"([\d.]+) [\d.]+", shade), float)
        scale = (at[40] - at[0]) / 40.0
        assert x[[0, -1]] == pytest.approx([at[0] + 35 * scale, at[0] + 40 * scale], abs=0.3)


def test_upward__is_where_a_body_flies_against_its_coordinate() -> None:
    setup = {"outline": {"shapes": [{"heading": (0.0, -1.0)}, {"heading": None}]}}
    assert upward(setup) == -1.0
    assert upward(None) == 1.0


def test_setup__keeps_long_names_of_materials_inside_and_off_the_axis() -> None:
    block = {"top": 0.0, "bottom": 0.04, "left": -0.0375, "right": 0.0375}
    cylinder = {"top": -0.004, "bottom": 0.0, "left": -0.0025, "right": 0.0025}
    shapes = [
        {**block, "body": "target", "heading": None, "is_disc": False},
        {**cylinder, "body": "projectile", "heading": (0.0, 1.0), "is_disc": False},
    ]
    drawn = setup_sketch(
        {
            "outline": {"shapes": shapes, "dimensions": []},
            "labels": {"speed": "4 to 7 km/s"},
            "materials": dict.fromkeys(("projectile", "target"), "copper-thesis-plastic"),
            "alt": "",
        }
    )
    (axis,) = set(re.findall(r'd="M ([\d.]+) [\d.]+ L \1 ', drawn))
    labels = [
        (x, anchor or "start", text)
        for anchor, x, text in re.findall(
            r'<text style="[^"]*?(?:text-anchor: (\w+)[^"]*)?" x="([\d.]+)"[^>]*>([^<]+)<', drawn
        )
    ]
    assert [text for _, _, text in labels].count("copper-thesis-plastic") == 2
    for x, anchor, text in labels:
        if text.endswith("km/s"):
            continue
        wide = 4.65 * len(text)
        left = float(x) - (wide if anchor == "end" else 0.0)
        assert left >= 0.0
        assert left + wide <= float(axis)
