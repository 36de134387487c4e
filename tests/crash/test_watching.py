"""An engineer watches a sweep and looks inside its runs, in a real browser."""

from collections.abc import Callable
from pathlib import Path

import pytest
import xarray as xr
from playwright.sync_api import Browser, Locator, Page, expect

from tests.claims.marked import Compared
from tests.claims.rows import at_least, equal
from tests.service.support.api import open_api, served
from tests.service.support.browser import PATIENCE, SCHEMES, WIDTHS, Scheme, chromium, faults_of, window
from tests.service.support.serving import Service, serving

SWEEP = {
    "name": "watched",
    "title": "Holes that are watched",
    "scenario": "thin_plate",
    "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm"},
    "axes": {"speed": ["4 km/s", "5 km/s", "6 km/s"], "plate_thickness": ["2 mm", "3 mm"]},
    "resolution": 32,  # seconds each, so that cells fill one after the other
}
ENDLESS = {**SWEEP, "name": "endless", "title": "To be cancelled", "resolution": 64}
# Pixels of a canvas that are drawn, as text: two that differ are two pictures.
PICTURE = "canvas => canvas.toDataURL()"


@pytest.mark.browser
@pytest.mark.claim("pages", "watching", minutes=1.5)
@pytest.mark.claim("contract", "watching", minutes=1.5)
def test_browser__watches_a_sweep_and_looks_inside_its_runs(tmp_path: Path, compared: Compared) -> None:
    """In a browser a sweep fills its grid; a run's film slides and its matter turns, by keys too; the cube is one.

    At 400 and 1400 px, light and dark, no page has a message, a request elsewhere, a serious violation of
    accessibility, or anything beyond the window.
    """
    data = tmp_path / "data"
    data.mkdir()
    with serving(data) as service, chromium() as browser:
        id = service.submit(SWEEP, keep="film")
        _watch(browser, service, compared)
        for width in WIDTHS:
            for scheme in SCHEMES:
                _look_inside(browser, service, width, scheme, compared)
        cube = _cube(browser, service, id, tmp_path / "cube.nc")
        compared(equal("values in the cube", expected=(3, 2, True), got=cube))
        _cancel(browser, service, compared)


@pytest.mark.browser
@pytest.mark.claim("pages", "watching-by-keys", minutes=0.1)
def test_browser__renews_a_page_whose_button_has_the_focus(tmp_path: Path) -> None:
    """While the button Cancel of a sweep has the focus, its state is renewed, and the button keeps the focus."""
    with open_api(tmp_path) as api, served(api) as url, chromium() as browser, window(browser) as (page, _, _):
        id = api.submit()
        page.goto(f"{url}/sweeps/{id}")
        cancel, state = page.get_by_role("button", name="Cancel"), page.locator("#status .state")
        cancel.focus()
        expect(state).to_have_text("queued")
        api.store.leases.take(2, api.term())
        expect(state).to_have_text("running", timeout=PATIENCE)
        expect(cancel).to_be_focused()
        expect(page.locator("#status > *")).to_have_count(3)


def _watch(browser: Browser, service: Service, compared: Compared) -> None:
    """From the list to the sweep, until its report is there; nothing is loaded by hand."""
    with window(browser) as (page, _, _):
        page.goto(service.url)
        page.get_by_role("searchbox").fill("watched")
        page.keyboard.press("Enter")
        page.get_by_role("link", name=str(SWEEP["title"])).click()
        expect(page.locator(".cells")).to_be_visible()
        waiting = page.locator(".cells td:not(.succeeded) a")
        seen = set()
        while left := waiting.count():
            seen.add(left)
            expect(waiting).not_to_have_count(left, timeout=PATIENCE)
        compared(at_least("numbers of unfinished cells that were seen", limit=2, got=len(seen)))
        expect(page.locator("#status .headline")).to_be_visible(timeout=PATIENCE)
        expect(page.locator("#report img.wide")).to_be_visible(timeout=PATIENCE)


def _look_inside(browser: Browser, service: Service, width: int, scheme: Scheme, compared: Compared) -> None:
    where = f"{width} px, {scheme}"
    with window(browser, width, scheme) as (page, messages, requests):
        _turn(page, service, where, compared)
    compared(equal(f"{where}: messages", expected=[], got=messages))
    foreign = [url for url in requests if not url.startswith((service.url, "data:", "blob:"))]
    compared(equal(f"{where}: requests elsewhere", expected=[], got=foreign))


def _turn(page: Page, service: Service, where: str, compared: Compared) -> None:
    """From the list to the film and the matter of a run, and back."""
    page.goto(service.url)
    _compare(page, f"{where}: list", compared)
    page.get_by_role("link", name=str(SWEEP["title"])).click()
    _compare(page, f"{where}: sweep", compared)
    cell = page.locator(".cells td.succeeded a").first
    cell.focus()
    page.keyboard.press("Enter")
    film, cloud = (page.locator(f".view.{name}") for name in ("film", "cloud"))
    for view in (film, cloud):
        view.scroll_into_view_if_needed()
        expect(view.locator("> canvas")).to_be_visible(timeout=PATIENCE)
    slider = film.get_by_role("slider", name="Time")
    compared(equal(f"{where}: the film slides", expected=True, got=_changes(film, lambda: slider.press("Home"))))
    key = lambda: cloud.locator("> canvas").press("ArrowRight")  # noqa: E731
    compared(equal(f"{where}: arrow keys turn the matter", expected=True, got=_changes(cloud, key)))
    compared(equal(f"{where}: dragging turns it", expected=True, got=_changes(cloud, lambda: _drag(page, cloud))))
    choose = lambda: film.get_by_role("combobox").select_option("temperature")  # noqa: E731
    compared(equal(f"{where}: another field is another picture", expected=True, got=_changes(film, choose)))
    _compare(page, f"{where}: run", compared)
    page.go_back()
    page.get_by_role("link", name="Report", exact=True).click()
    expect(page.locator("h1")).to_have_text(str(SWEEP["title"]))


def _compare(page: Page, where: str, compared: Compared) -> None:
    """What no page may have, with all that is folded open."""
    page.evaluate("document.querySelectorAll('details').forEach(each => each.open = true)")
    compared(*faults_of(page, where))


def _changes(view: Locator, act: Callable[[], object]) -> bool:
    """Whether the picture of a view is another one after an act."""
    before = view.locator("> canvas").evaluate(PICTURE)
    act()
    return bool(view.locator("> canvas").evaluate(PICTURE) != before)


def _drag(page: Page, view: Locator) -> None:
    box = view.locator("> canvas").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 100, box["y"] + 100)
    page.mouse.down()
    page.mouse.move(box["x"] + 180, box["y"] + 130, steps=4)
    page.mouse.up()


def _cube(browser: Browser, service: Service, id: str, file: Path) -> tuple[int, int, bool]:
    """Sizes of the axes of the cube that a page offers, and whether every run has a value."""
    with window(browser) as (page, _, _):
        page.goto(f"{service.url}/sweeps/{id}")
        with page.expect_download() as download:
            page.get_by_role("link", name="Cube").click()
        download.value.save_as(file)
    with xr.open_dataset(file) as cube:
        hole = cube.hole_diameter
        return hole.sizes["speed"], hole.sizes["plate_thickness"], bool(hole.notnull().all())


def _cancel(browser: Browser, service: Service, compared: Compared) -> None:
    id = service.submit(ENDLESS)
    with window(browser) as (page, _, _):
        page.goto(f"{service.url}/sweeps/{id}")
        page.get_by_role("button", name="Cancel").press("Enter")
        expect(page.locator("#status .state")).to_have_text("cancelled", timeout=PATIENCE)
        cells = page.locator(".cells td a").all_inner_texts()
    compared(equal("cells of a cancelled sweep", expected=["cancelled"] * 6, got=cells))
