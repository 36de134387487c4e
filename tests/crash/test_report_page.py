"""The report in a real browser, from disk: figures and pictures are drawn, and nothing is asked of the network."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

import whipple
from studies.cases.rows import Row, at_most, equal
from studies.reports.publish import publish_sweep
from tests.claims.marked import Compared, claimed
from tests.crash.support.browser import CHROMIUM, HEIGHT, SCHEMES, WIDTHS, chromium, look, opened, print_page, rows_of
from tests.studies.runs.solved import solved
from tests.studies.support import fakes

# Pictures of the claim stay here, to be looked at.
FOLDER = Path(__file__).parents[2] / ".cache" / "report-page"
HOLES = {
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
            """() => [...document.querySelectorAll("[data-plot]")].map(place =>
                [...place.querySelectorAll("svg.chart")].filter(svg => svg.getBoundingClientRect().width > 0)
                    .map(svg => svg.classList[2]))"""
        )
    assert drawn
    assert all(set(kinds) == {"wide" if width == max(WIDTHS) else "narrow"} for kinds in drawn)


def test_page__shows_every_picture_with_its_text(browser: Browser, report: Path) -> None:
    with opened(browser, report, max(WIDTHS)) as (page, _, _):
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


def test_page__is_quiet_whole_and_accessible(browser: Browser, report: Path, compared: Compared) -> None:
    compared(*rows_of(look(browser, report, min(WIDTHS), "dark"), "narrow and dark"))


# Lower ends of what is seen first, px: headline, figure and picture.
FIRST = """() => [".headline", ".sides svg.chart", ".sides svg.of-run"].map(kind => Math.max(
    ...[...document.querySelectorAll(kind)].map(each => each.getBoundingClientRect().bottom)))"""
SHEET = (703, 1032)  # what margins of 12 mm leave of A4, px at 96 to the inch


@pytest.mark.parametrize("width", claimed(WIDTHS, WIDTHS[:1], "door", "first-screen"))
def test_page__shows_headline_figure_and_picture_on_the_first_screen(
    browser: Browser, report: Path, width: int, compared: Compared
) -> None:
    """The first screen of a report, 400 or 1400 px wide and 900 high, has its headline, main figure and a picture."""
    with opened(browser, report, width) as (page, _, _):
        ends = page.evaluate(FIRST)
    for what, end in zip(("headline", "figure", "picture"), ends, strict=True):
        compared(at_most(f"{width} px: end of the {what} (px)", limit=HEIGHT, got=end))
    compared(Row(f"{width} px: each is there", "above 0", str(ends), all(end > 0 for end in ends)))


@pytest.mark.claim("door", "first-sheet")
def test_page__prints_the_opening_on_one_sheet_and_then_the_rest(
    browser: Browser, report: Path, compared: Compared
) -> None:
    """Headline, figure, picture and numbers are one sheet of A4; what is folded on the screen begins on the next."""
    with opened(browser, report, max(WIDTHS)) as (page, _, _):
        folded = page.evaluate("document.querySelectorAll('details.section[open]').length")
        page.set_viewport_size({"width": SHEET[0], "height": SHEET[1]})
        page.emulate_media(media="print")
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        height, after, closed = page.evaluate(
            """() => [document.querySelector(".opening").getBoundingClientRect().bottom,
                getComputedStyle(document.querySelector(".opening")).breakAfter,
                document.querySelectorAll("details.section:not([open])").length]"""
        )
    compared(at_most("height of the opening on paper (px)", limit=SHEET[1], got=height))
    compared(
        equal("open on the screen, closed on paper, break after", expected=(0, 0, "page"), got=(folded, closed, after))
    )


@pytest.mark.claim("report", "report-page", minutes=2.0)
def test_page__of_computed_runs(browser: Browser, compared: Compared) -> None:
    """A report with pictures has at most 8 MB; in Chromium at 400 and 1400 px, light, dark and printed, all is well.

    There is no message, no request, nothing cut off and no serious violation of accessibility.
    """
    report = Path(whipple.run_sweep(HOLES, FOLDER / "holes", overwrite=True)) / "report.html"
    compared(at_most("size of the report (MB)", limit=8.0, got=report.stat().st_size / 1e6))
    for width in WIDTHS:
        for scheme in SCHEMES:
            seen = look(browser, report, width, scheme, FOLDER / f"{width}-{scheme}.png")
            for row in rows_of(seen, f"{width} px, {scheme}"):
                compared(row)
    for row in print_page(browser, report, FOLDER / "report.pdf"):
        compared(row)
    compared(Row("pictures of the page", "", str(FOLDER), None))
