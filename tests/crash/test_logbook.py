"""The list of sweeps in a real browser that needs a key: two are compared by keys alone, and links can be kept."""

from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from service.records.jobs import Scope
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support.api import SWEEP, open_api, served
from tests.service.support.browser import PATIENCE, SCHEMES, WIDTHS, chromium, faults_of, window
from tests.service.support.fakes import issue_key

OTHER = {**SWEEP, "resolution": 12, "axes": {"speed": ["6 km/s", "7 km/s"]}}


@pytest.mark.browser
@pytest.mark.claim("contract", "comparison", minutes=0.6)
def test_browser__compares_two_sweeps_by_keys_alone(tmp_path: Path, compared: Compared) -> None:
    """List and comparison at 400 and 1400 px, light and dark, with a key and by keys alone; axe finds nothing."""
    secret = issue_key(tmp_path, "anna", Scope.ADMIN)
    headers = {"Authorization": f"Bearer {secret}", "Host": "127.0.0.1"}
    with open_api(tmp_path, host="0.0.0.0") as api, served(api) as url, chromium() as browser:
        for sweep in (SWEEP, OTHER):
            assert api.http.post("/v1/sweeps", json=sweep, headers=headers).status_code == 202
        api.compute()
        for width in WIDTHS:
            for scheme in SCHEMES:
                with window(browser, width, scheme) as (page, messages, _):
                    _compare_by_keys(page, url, secret, f"{width} px, {scheme}", compared)
                others = [text for text in messages if "401" not in text]
                compared(equal(f"{width} px, {scheme}: messages", expected=[], got=others))


def _compare_by_keys(page: Page, url: str, secret: str, where: str, compared: Compared) -> None:
    page.goto(f"{url}/?order=title")
    expect(page.get_by_label("API key")).to_be_focused(timeout=PATIENCE)
    page.keyboard.insert_text(secret)
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="Sweeps")).to_be_visible(timeout=PATIENCE)
    compared(*faults_of(page, f"{where}: list"))
    boxes = page.get_by_role("checkbox", name="Compare")
    for place in range(2):
        boxes.nth(place).focus()
        page.keyboard.press("Space")
    page.get_by_role("button", name="Compare two ticked sweeps").focus()
    page.keyboard.press("Enter")
    expect(page.get_by_role("heading", name="In what they differ")).to_be_visible(timeout=PATIENCE)
    compared(*faults_of(page, f"{where}: comparison"))
    kept = page.url
    page.goto(kept)
    expect(page.locator("img.chart")).to_have_count(1)
