"""The pages with which a person asks, in a real browser: on a telephone and on a desk, with and without scripts."""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect

from service.settings import Settings
from service.store import Store
from studies import materials
from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from studies.sweeps.sweep import Sweep
from tests.claims.marked import Compared
from tests.claims.rows import Row, equal
from tests.service.support.browser import PATIENCE, SCHEMES, WIDTHS, Scheme, chromium, faults_of, violations_of, window
from tests.service.support.processes import ROOT
from tests.service.support.serving import Service, http, serving

PAGES = (
    *("/", "/new", "/new/thin_plate", "/new/whipple_shield?preset=shield", "/shields", "/shields?speed=6"),
    *("/scenarios", "/laws", "/materials", "/materials/copper-ofhc", "/shots", "/shots/holes", "/shots/shields"),
)
# Formulas do not break inside.
CUT_FORMULAS = """() => [...document.querySelectorAll("math")]
    .filter(each => each.getBoundingClientRect().right > innerWidth + 1).map(each => each.textContent)"""
PRESET = "smoke"
SHIPPED = len(materials.names())


@pytest.fixture
def service(tmp_path: Path) -> Iterator[Service]:
    """A service that computes nothing."""
    data = tmp_path / "data"
    data.mkdir()
    with closing(Store.open(Settings(data=data).url)) as store:
        store.queue.pause()
    with serving(data) as running:
        yield running


@pytest.mark.browser
@pytest.mark.claim("pages", "asking", minutes=2.0)
@pytest.mark.claim("contract", "asking", minutes=2.0)
@pytest.mark.parametrize("width", WIDTHS)
def test_page__reads_on_a_telephone_and_on_a_desk(service: Service, width: int, compared: Compared) -> None:
    """Pages with which a person asks: no serious violation of accessibility, no message, no request elsewhere."""
    with chromium() as browser:
        for scheme in SCHEMES:
            for row in looked_at(service, browser, width, scheme):
                compared(row)


def looked_at(service: Service, browser: Browser, width: int, scheme: Scheme) -> Iterator[Row]:
    """What must not be there on any page, in a window of a width."""
    with window(browser, width, scheme) as (page, messages, requests):
        for path in PAGES:
            page.goto(f"{service.url}{path}")
            where = f"{path}, {width} px, {scheme}"
            yield from faults_of(page, where)
            yield equal(f"{where}: formulas beyond the window", expected=[], got=page.evaluate(CUT_FORMULAS))
    elsewhere = [url for url in requests if not url.startswith((service.url, "data:"))]
    yield equal(f"{width} px, {scheme}: messages", expected=[], got=messages)
    yield equal(f"{width} px, {scheme}: requests elsewhere", expected=[], got=elsewhere)


@pytest.mark.browser
@pytest.mark.claim("pages", "new-sweep", minutes=1.0)
def test_form__follows_what_is_written_and_submits_a_preset(service: Service, compared: Compared) -> None:
    """The form of a new sweep shows cost, set-up and findings while it is written, and submits by its button alone."""
    with chromium() as browser, window(browser) as (page, messages, _):
        page.goto(f"{service.url}/")
        page.get_by_role("link", name="Fill in a form").click()
        page.get_by_role("link", name="Smoke test").click()
        expect(page.locator(".cost")).to_contain_text("2 runs", timeout=PATIENCE)
        before = page.locator("#preview img").get_attribute("src")
        options = "id => document.getElementById(id).list.options.length"
        suggested = {name: page.evaluate(options, name) for name in ("projectile", "target")}
        compared(equal("materials that are suggested", expected=dict.fromkeys(suggested, SHIPPED), got=suggested))
        page.get_by_label("Projectile diameter").fill("10 mm")
        page.get_by_label("Speed", exact=False).first.fill("3 km/s, 6 km/s, 7 km/s")
        expect(page.locator(".cost")).to_contain_text("3 runs", timeout=PATIENCE)
        drawn = page.locator("#preview img").get_attribute("src") != before
        compared(equal("the set-up follows the numbers", expected=True, got=drawn))
        compared(equal("the request follows", expected=True, got="7 km/s" in page.locator("pre").first.inner_text()))
        page.get_by_label("Projectile diameter").fill("10")
        expect(page.locator("#finding-projectile_diameter")).to_contain_text("10 mm", timeout=PATIENCE)
        compared(equal("serious violations with a finding", expected=[], got=violations_of(page)))
        page.get_by_label("Projectile diameter").fill("10 mm")
        page.keyboard.press("Enter")
        expect(page.locator("#finding-projectile_diameter")).to_be_empty(timeout=PATIENCE)
        compared(equal("sweeps after Enter", expected=0, got=len(sweeps(service))))
        page.get_by_role("button", name="Submit sweep").click()
        expect(page.locator(".state")).to_have_text("queued", timeout=PATIENCE)
        compared(equal("sweeps after Submit", expected=1, got=len(sweeps(service))))
        compared(equal("messages on the console", expected=[], got=messages))


@pytest.mark.browser
@pytest.mark.claim("pages", "new-sweep", minutes=0.5)
def test_form__works_without_scripts(service: Service, compared: Compared) -> None:
    """Without scripts the form of a new sweep shows its findings, keeps what was written, and submits."""
    with chromium() as browser, window(browser, java_script_enabled=False) as (page, _, _):
        page.goto(f"{service.url}/new/thin_plate?preset={PRESET}")
        thickness = page.get_by_label("Plate thickness")
        thickness.fill("2")
        page.keyboard.press("Enter")
        expect(page.locator("#finding-plate_thickness")).to_contain_text("2 mm")
        compared(equal("sweeps after Enter", expected=0, got=len(sweeps(service))))
        compared(equal("the field keeps its text", expected="2", got=thickness.input_value()))
        thickness.fill("2 mm")
        page.get_by_role("button", name="Submit sweep").click()
        expect(page.locator(".state")).to_have_text("queued")
        compared(equal("sweeps after Submit", expected=1, got=len(sweeps(service))))


@pytest.mark.browser
@pytest.mark.claim("pages", "same-request", minutes=0.5)
def test_request__is_the_same_by_form_curl_python_and_yaml(
    service: Service, tmp_path: Path, compared: Compared
) -> None:
    """A sweep has the same runs by its form, and by the curl, the Python and the YAML that its page shows."""
    expected = {point.run.id for point in Sweep.parse(read_yaml(examples.text(PRESET), PRESET)).runs()}
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    with chromium() as browser, window(browser) as (page, _, _):
        page.goto(f"{service.url}/new/thin_plate?preset={PRESET}")
        texts = {name: shown(page, name) for name in ("curl", "python", "yaml")}
        page.get_by_role("button", name="Submit sweep").click()
        expect(page.locator(".state")).to_have_text("queued", timeout=PATIENCE)
        compared(equal("runs by the form", expected=expected, got=runs_of(service, page.url.rpartition("/")[2])))
    file = tmp_path / "sweep.yaml"
    file.write_text(texts["yaml"], encoding="utf-8")
    submit = [sys.executable, "-m", "service", "submit", str(file), "--url", service.url]
    commands = {"curl": ["sh", "-c", texts["curl"]], "python": [sys.executable, "-c", texts["python"]], "yaml": submit}
    for name, command in commands.items():
        subprocess.run(command, check=True, capture_output=True, env=environment, cwd=tmp_path, timeout=PATIENCE / 1e3)
        latest = sweeps(service)[0]["id"]
        compared(equal(f"runs by {name}", expected=expected, got=runs_of(service, latest)))
    compared(equal("sweeps", expected=4, got=len(sweeps(service))))


def shown(page: Page, language: str) -> str:
    """A request that a page shows in a language."""
    return page.locator(f"pre[data-language={language}]").text_content() or ""


def sweeps(service: Service) -> list[dict[str, str]]:
    items: list[dict[str, str]] = http().get(f"{service.url}/v1/sweeps", timeout=PATIENCE).json()["items"]
    return items


@pytest.mark.browser
@pytest.mark.claim("mend", "tables-in-a-browser", minutes=0.5)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_form__takes_a_table_of_shots_in_any_encoding(service: Service, encoding: str, compared: Compared) -> None:
    """A file that is chosen on the page of a new sweep fills its field, in UTF-8, UTF-16 and Windows-1252."""
    table = "speed [km/s];hole_diameter [mm];source\n5,1;18,3±0,4;März\n"
    with chromium() as browser, window(browser) as (page, messages, _):
        page.goto(f"{service.url}/new/thin_plate")
        file = {"name": "shots.csv", "mimeType": "text/csv", "buffer": table.encode(encoding)}
        page.locator("input[data-into=observations]").set_input_files(file)  # type: ignore[arg-type]
        expect(page.locator("#observations")).to_have_value(table, timeout=PATIENCE)
        compared(equal(f"{encoding}: messages", expected=[], got=messages))


def runs_of(service: Service, sweep: str) -> set[str]:
    points = http().get(f"{service.url}/v1/sweeps/{sweep}/runs", timeout=PATIENCE).json()["items"]
    return {point["run"]["id"] for point in points}
