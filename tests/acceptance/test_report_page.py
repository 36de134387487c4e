"""The report in a real browser, from disk: figures and pictures are drawn, and nothing is asked of the network."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from studies.reports.publish import publish_sweep
from tests.acceptance.support.browser import (
    CHROMIUM,
    SCHEMES,
    WIDTHS,
    Scheme,
    chromium,
    look,
    opened,
    print_page,
    rows_of,
)
from tests.rows import check
from tests.studies.runs.solved import solved
from tests.studies.support import fakes

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


@pytest.fixture(scope="module")
def html(browser: Browser, report: Path) -> str:
    """The page after its scripts have run."""
    with opened(browser, report, max(WIDTHS)) as (page, _, _):
        return page.content()


def test_page__draws_every_figure(html: str) -> None:
    places = re.findall(r"<div [^>]*data-plot=[^>]*>", html)
    assert places
    assert all("js-plotly-plot" in place for place in places)
    assert len(re.findall(r'class="[^"]*svg-container', html)) == len(places)


def test_page__shows_every_series_in_the_legend(html: str) -> None:
    legend = set(re.findall(r'class="legendtext"[^>]*>([^<]+)<', html))
    laws = {"thesis 1-3, aluminium", "thesis 1-4", "thesis 1-5, all constants"}
    assert {"simulation", "observed", "run without a value", *laws} <= legend


def test_page__shows_every_picture_with_its_text(browser: Browser, report: Path) -> None:
    with opened(browser, report, max(WIDTHS)) as (page, _, _):
        shown = page.evaluate(
            """() => [...document.querySelectorAll("svg.picture image")].map(async image => {
                const bitmap = new Image();
                bitmap.src = image.href.baseVal;
                await bitmap.decode();
                return [bitmap.width, image.closest("svg").getAttribute("aria-label")];
            }).reduce(async (all, one) => [...await all, await one], [])"""
        )
    assert len(shown) > 20
    assert all(width > 100 and "Section" in label for width, label in shown)


# All four of them are looked at by the claim report-page.
@pytest.mark.parametrize(("width", "scheme"), [*zip(WIDTHS, reversed(SCHEMES), strict=True)])
def test_page__is_quiet_whole_and_accessible(browser: Browser, report: Path, width: int, scheme: Scheme) -> None:
    check(rows_of(look(browser, report, width, scheme), f"{width} px, {scheme}"))


def test_page__prints_on_paper(browser: Browser, report: Path, tmp_path: Path) -> None:
    check(print_page(browser, report, tmp_path / "report.pdf"))
