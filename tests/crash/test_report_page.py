"""The report in a real browser, from disk: figures and pictures are drawn, and nothing is asked of the network."""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Browser

import whipple
from studies.quantities.parameters import Plain
from studies.reports.publish import publish_sweep
from studies.sweeps.axes import Axis
from studies.sweeps.sweep import Sweep
from tests.claims.marked import Compared, claimed
from tests.claims.rows import Row, at_most
from tests.service.support.browser import CHROMIUM, HEIGHT, SCHEMES, WIDTHS, chromium, opened, print_page, rows_of
from tests.studies.runs.solved import solved
from tests.studies.support import fakes

# Pictures of the claim stay here, to be looked at.
FOLDER = Path(__file__).parents[2] / ".cache" / "report-page"
HOLES: Mapping[str, Plain] = {
    "name": "page",
    "title": "Holes in copper plates, 8 mm copper sphere",
    "scenario": "thin_plate",
    "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm"},
    "axes": {"speed": ["3 km/s", "5 km/s", "6.5 km/s"], "plate_thickness": ["2 mm", "3 mm"]},
    "resolution": 16,
}
pytestmark = [pytest.mark.browser, pytest.mark.skipif(not CHROMIUM, reason="no Chromium: name one in WHIPPLE_CHROMIUM")]


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report with laws, shots, failed runs, pictures, and pictures that are missing."""
    sweep = fakes.holes()
    catalogue = fakes.catalogue(observations=fakes.SHOTS)
    file = solved("thin_plate") / "sections.npz"
    sections = {point.run.id: file for point in sweep.runs()[::2]}
    folder = tmp_path_factory.mktemp("report")
    files = publish_sweep(sweep, fakes.with_trouble(sweep), folder, catalogue, sections)
    return Path(files["report.html"])


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as browser:
        yield browser


@pytest.mark.parametrize("width", claimed(WIDTHS, WIDTHS[1:], "report", "width-of-figures"))
def test_page__draws_every_figure_as_wide_as_it_is(browser: Browser, report: Path, width: int) -> None:
    """Every figure of a report is drawn for the width of the window."""
    with opened(browser, report, width) as (page, _, _):
        drawn = page.evaluate(
            """() => [...document.querySelectorAll("[data-plot]")].filter(each => each.offsetHeight).map(place =>
                [...place.querySelectorAll("svg.chart")].filter(svg => svg.getBoundingClientRect().width > 0)
                    .map(svg => svg.classList[2]))"""
        )
    assert drawn
    assert all(set(kinds) == {"wide" if width == max(WIDTHS) else "narrow"} for kinds in drawn)


def test_page__shows_every_picture_with_its_text(browser: Browser, report: Path) -> None:
    with opened(browser, report.with_name("appendix.html"), max(WIDTHS)) as (page, _, _):
        shown = page.evaluate(
            """() => [...document.querySelectorAll("svg.of-run")].map(async svg => {
                const image = svg.querySelector("image");
                const bitmap = new Image();
                bitmap.src = image.href.baseVal;
                await bitmap.decode();
                return [bitmap.width, svg.getAttribute("aria-label")];
            }).reduce(async (all, one) => [...await all, await one], [])"""
        )
    assert len(shown) > 20
    assert all(width > 100 and "Section" in label for width, label in shown)


PAGES = ("report.html", "appendix.html")


@pytest.mark.parametrize("name", claimed(PAGES, PAGES[:1], "report", "quiet-pages"))
def test_pages__are_quiet_whole_and_accessible(browser: Browser, report: Path, name: str, compared: Compared) -> None:
    """Report and appendix are quiet, whole and accessible on a narrow screen in the dark."""
    compared(*rows_of(browser, report.with_name(name), min(WIDTHS), "dark"))


# Lower ends of what is seen first, px: headline, figure, and the first row that is not the name of a column.
FIRST = """() => [".headline", ".sides svg.chart", ".opening tr"].map(kind => Math.min(
    ...[...document.querySelectorAll(kind)].map(each => each.getBoundingClientRect().bottom).filter(end => end > 0)))"""


@pytest.mark.parametrize("width", claimed(WIDTHS, WIDTHS[:1], "report", "first-screen"))
def test_page__shows_headline_figure_and_table_on_the_first_screen(
    browser: Browser, report: Path, width: int, compared: Compared
) -> None:
    """The first screen of a report, 400 or 1400 px wide and 900 high, has headline, main figure and a table's head."""
    with opened(browser, report, width) as (page, _, _):
        ends = page.evaluate(FIRST)
    for what, end in zip(("headline", "figure", "head of the table"), ends, strict=True):
        compared(at_most(f"{width} px: end of the {what} (px)", limit=HEIGHT, got=end))


MOST_SHEETS, MOST_WORDS, MOST_FIGURES = 6, 3000, 12
COUNTED = """() => [document.querySelector("main").innerText.split(/\\s+/).length,
    [...document.querySelectorAll("figure")].filter(figure => figure.offsetHeight && !figure.querySelector("figure"))
        .length]"""


def axis(name: str, unit: str | None, count: int) -> Axis:
    """So many values of an axis."""
    low, high = {"speed": (2e3, 7e3), "plate_thickness": (1e-3, 6e-3), "projectile_diameter": (4e-3, 12e-3)}[name]
    return Axis(name, unit, tuple(np.linspace(low, high, count).tolist()))


def sizes(scenario: str) -> Iterator[tuple[str, Sweep]]:
    """Ten sweeps of a scenario, from one point to two thousand, on one grid and on several."""
    other = ("plate_thickness", "m") if scenario == "thin_plate" else ("projectile_diameter", "m")
    for speeds, others in ((1, 1), (2, 1), (6, 1), (30, 1), (6, 3), (4, 12), (50, 40)):
        axes = [axis("speed", "m s-1", speeds), axis(*other, others)]
        yield f"{scenario}, {speeds} by {others}", fakes.sweep_of(*axes, scenario=scenario)
    for cells, offsets in (((16.0, 32.0, 64.0), 1), ((16.0, 32.0, 64.0), 3), ((20.0,), 5)):
        name = f"{scenario}, {len(cells)} grids at {offsets} offsets"
        yield name, fakes.sweep_of(axis("speed", "m s-1", 4), scenario=scenario, resolutions=cells, offsets=offsets)


@pytest.mark.claim("report", "six-sheets", minutes=3.0)
@pytest.mark.parametrize("scenario", ["thin_plate", "thick_plate"])
def test_page__prints_on_six_sheets_whatever_the_sweep(
    browser: Browser, tmp_path: Path, scenario: str, compared: Compared
) -> None:
    """Reports of sweeps of 1 to 2 000 points have at most 6 printed pages, 3 000 words, 12 figures, 30 in the headline.

    A picture stands beside the figure, and six more on the page.
    """
    file = solved("thin_plate") / "sections.npz"
    for name, sweep in sizes(scenario):
        folder = tmp_path / name
        sections = {point.run.id: file for point in sweep.runs()[:40]}
        catalogue = fakes.catalogue(scenario, observations=fakes.SHOTS if scenario == "thin_plate" else ())
        publish_sweep(sweep, fakes.results(sweep), folder, catalogue, sections)
        headline = json.loads((folder / "report.json").read_text("utf-8"))["headline"]
        compared(at_most(f"{name}: words of the headline", limit=30, got=len(headline.split())))
        compared(Row(f"{name}: the headline is whole", "no …", headline, "…" not in headline))
        compared(*counted(browser, folder / "report.html", name))
        compared(at_most(f"{name}: appendix (MB)", limit=5.0, got=(folder / "appendix.html").stat().st_size / 1e6))


def counted(browser: Browser, report: Path, name: str) -> Iterator[Row]:
    """Printed pages, words and figures of a report."""
    with opened(browser, report, max(WIDTHS)) as (page, _, _):
        words, figures = page.evaluate(COUNTED)
        page.pdf(path=report.with_suffix(".pdf"), prefer_css_page_size=True)
    sheets = len(re.findall(rb"/Type\s*/Page\b[^s]", report.with_suffix(".pdf").read_bytes()))
    for what, limit, got in (
        ("sheets", MOST_SHEETS, sheets),
        ("words", MOST_WORDS, words),
        ("figures", MOST_FIGURES, figures),
    ):
        yield at_most(f"{name}: {what}", limit=limit, got=got)


@pytest.mark.claim("report", "report-page", minutes=2.0)
def test_page__of_computed_runs(browser: Browser, compared: Compared) -> None:
    """A report with pictures has at most 3 MB; in Chromium at 400 and 1400 px, light, dark and printed, all is well.

    There is no message, no request, nothing cut off and no serious violation of accessibility.
    """
    report = Path(whipple.run_sweep(HOLES, FOLDER / "holes", overwrite=True)) / "report.html"
    compared(at_most("size of the report (MB)", limit=3.0, got=report.stat().st_size / 1e6))
    for width in WIDTHS:
        for scheme in SCHEMES:
            compared(*rows_of(browser, report, width, scheme, FOLDER / f"{width}-{scheme}.png"))
    compared(*print_page(browser, report, FOLDER / "report.pdf"))
    compared(*counted(browser, report, "computed"))
    compared(Row("pictures of the page", "", str(FOLDER), None))
