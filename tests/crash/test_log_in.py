"""Log-in in a real browser, which sends the headers and cookies that a test client leaves out."""

from contextlib import closing
from pathlib import Path

import pytest
from playwright.sync_api import expect

from service.records.jobs import Scope
from service.settings import Settings
from service.store import Store
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support.api import SWEEP, open_api, served
from tests.service.support.browser import PATIENCE, WIDTHS, chromium, faults_of, window
from tests.service.support.fakes import issue_key
from tests.service.support.serving import http, serving


@pytest.mark.browser
@pytest.mark.claim("pages", "appendix", minutes=0.1)
def test_browser__opens_the_appendix_from_the_report_of_a_service_that_needs_a_key(
    tmp_path: Path, compared: Compared
) -> None:
    """The link in the report opens the appendix, and so does that of the page of the sweep."""
    secret = issue_key(tmp_path, "anna", Scope.ADMIN)
    headers = {"Authorization": f"Bearer {secret}", "Host": "127.0.0.1"}
    with open_api(tmp_path, host="0.0.0.0") as api, served(api) as url, chromium() as browser:
        id = api.http.post("/v1/sweeps", json=SWEEP, headers=headers).json()["id"]
        api.compute()
        with window(browser) as (page, messages, _):
            page.goto(f"{url}/login")
            page.get_by_label("API key").fill(secret)
            page.keyboard.press("Enter")
            expect(page.get_by_role("heading", name="Sweeps")).to_be_visible(timeout=PATIENCE)
            page.goto(f"{url}/v1/sweeps/{id}/report.html")
            with page.expect_popup() as opened:
                page.get_by_role("link", name="Appendix", exact=True).click()
            expect(opened.value).to_have_title("appendix", timeout=PATIENCE)
            page.goto(f"{url}/sweeps/{id}")
            page.get_by_role("link", name="Appendix", exact=True).click()
            expect(page).to_have_title("appendix", timeout=PATIENCE)
            # It comes without the cookie, and is asked for again with it.
            others = [text for text in messages if "401" not in text]
            compared(equal("other messages on the console", expected=[], got=others))


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
                compared(*faults_of(page, f"{where}: log-in"))
                page.get_by_label("API key").fill(secret)
                page.keyboard.press("Enter")
                expect(page.get_by_role("heading", name="Sweeps")).to_be_visible(timeout=PATIENCE)
                sweep = {**SWEEP, "name": f"at-{width}"}
                answer = http().post(f"{service.url}/v1/sweeps", json=sweep, headers=key, timeout=PATIENCE)
                assert answer.status_code == 202, answer.text
                page.get_by_role("link", name=sweep["name"]).click()  # the list shows it by itself
                compared(*faults_of(page, f"{where}: sweep"))
                page.get_by_role("button", name="Cancel").click()
                expect(page.locator(".state")).to_have_text("cancelled", timeout=PATIENCE)
                page.get_by_role("button", name="Log out").click()
                expect(page.get_by_label("API key")).to_be_visible(timeout=PATIENCE)
                compared(equal(f"{where}: messages on the console", expected=[], got=messages))
                status = page.context.request.get(service.url).status
                compared(equal(f"{where}: status without a session", expected=401, got=status))
