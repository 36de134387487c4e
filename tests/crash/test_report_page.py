"""The report in a real browser, from disk: figures and pictures are drawn, and nothing is asked of the network."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

import whipple
from studies.cases.rows import Row, at_most
from studies.reports.publish import publish_sweep
from tests.crash.support.browser import CHROMIUM, SCHEMES, WIDTHS, Scheme, chromium, look, opened, print_page, rows_of
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


@pytest.mark.parametrize(("width", "kind"), [(max(WIDTHS), "wide"), (min(WIDTHS), "narrow")])
def test_page__draws_every_figure_as_wide_as_it_is(browser: Browser, report: Path, width: int, kind: str) -> None:
    with opened(browser, report, width) as (page, _, _):
        drawn = page.evaluate(
            """() => [...document.querySelectorAll("[data-plot]")].map(place =>
                [...place.querySelectorAll("svg.chart")].filter(svg => svg.getBoundingClientRect().width > 0)
                    .map(svg => svg.classList[2]))"""
        )
    assert drawn
    assert all(set(kinds) == {kind} for kinds in drawn)


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


@pytest.mark.parametrize(("width", "scheme"), [*zip(WIDTHS, reversed(SCHEMES), strict=True)])
def test_page__is_quiet_whole_and_accessible(
    browser: Browser, report: Path, width: int, scheme: Scheme, compared: Callable[..., None]
) -> None:
    compared(*rows_of(look(browser, report, width, scheme), f"{width} px, {scheme}"))


def test_page__prints_on_paper(browser: Browser, report: Path, tmp_path: Path, compared: Callable[..., None]) -> None:
    compared(*print_page(browser, report, tmp_path / "report.pdf"))


@pytest.mark.claim("report", "report-page", minutes=2.0)
def test_page__of_computed_runs(browser: Browser, compared: Callable[[Row], None]) -> None:
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
