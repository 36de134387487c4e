"""Log-in in a real browser, which sends the headers and cookies that a test client leaves out."""

from contextlib import closing
from pathlib import Path

import pytest
from playwright.sync_api import expect

from service.records.jobs import Scope
from service.settings import Settings
from service.store import Store
from studies.cases.rows import equal
from tests.claims.marked import Compared
from tests.crash.support.browser import BEYOND, PATIENCE, WIDTHS, chromium, violations_of, window
from tests.crash.support.serving import http, serving
from tests.service.support.api import SWEEP


@pytest.mark.browser
@pytest.mark.claim("pages", "log-in", minutes=0.3)
def test_browser__logs_in_cancels_and_logs_out(tmp_path: Path, compared: Compared) -> None:
    """A browser is asked for a key, logs in, sees a sweep that is submitted meanwhile, cancels it and logs out."""
    data = tmp_path / "data"
    data.mkdir()
    with closing(Store.open(Settings(data=data).url)) as store:
        _, secret = store.keys.issue("anna", [Scope.SUBMIT])
        store.queue.pause()
    key = {"Authorization": f"Bearer {secret}"}
    with serving(data, WHIPPLE_HOST="0.0.0.0") as service, chromium() as browser:
        for width in WIDTHS:
            with window(browser, width) as (page, messages, _):
                where = f"{width} px"
                page.goto(f"{service.url}/login")
                compared(equal(f"{where}: serious violations of the log-in", expected=[], got=violations_of(page)))
                page.get_by_label("API key").fill(secret)
                page.keyboard.press("Enter")
                expect(page.get_by_role("heading", name="Sweeps")).to_be_visible(timeout=PATIENCE)
                sweep = {**SWEEP, "name": f"at-{width}"}
                answer = http().post(f"{service.url}/v1/sweeps", json=sweep, headers=key, timeout=PATIENCE)
                assert answer.status_code == 202, answer.text
                page.get_by_role("link", name=sweep["name"]).click()  # the list shows it by itself
                compared(equal(f"{where}: serious violations of a sweep", expected=[], got=violations_of(page)))
                page.get_by_role("button", name="Cancel").click()
                expect(page.locator(".state")).to_have_text("cancelled", timeout=PATIENCE)
                compared(equal(f"{where}: wider than the window (px)", expected=0, got=page.evaluate(BEYOND)))
                page.get_by_role("button", name="Log out").click()
                expect(page.get_by_label("API key")).to_be_visible(timeout=PATIENCE)
                compared(equal(f"{where}: messages on the console", expected=[], got=messages))
                status = page.context.request.get(service.url).status
                compared(equal(f"{where}: status without a session", expected=401, got=status))
