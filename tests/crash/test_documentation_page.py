"""The page of the API in a real browser."""

from collections.abc import Callable
from pathlib import Path

import pytest

from studies.cases.rows import Row, equal
from tests.crash.support.browser import CUT, WIDTHS, chromium, messages_of, violations_of
from tests.service.support.api import open_api, served

BEYOND = "(main => main.scrollWidth - main.clientWidth)(document.querySelector('main'))"


@pytest.mark.browser
@pytest.mark.claim("pages", "api-page", minutes=0.2)
def test_documentation__is_accessible_and_fits_a_phone(tmp_path: Path, compared: Callable[[Row], None]) -> None:
    """The page of the API has no serious violation of accessibility (axe), and nothing on it reaches beyond a phone."""
    with open_api(tmp_path) as api, served(api) as url, chromium() as browser:
        for width in WIDTHS:
            page = browser.new_page(viewport={"width": width, "height": 900})
            messages = messages_of(page)
            page.goto(f"{url}/docs")
            compared(equal(f"{width} px: serious violations", expected=[], got=violations_of(page)))
            compared(equal(f"{width} px: elements beyond the window", expected=[], got=page.evaluate(CUT)))
            compared(equal(f"{width} px: content beyond the page, px", expected=0, got=page.evaluate(BEYOND)))
            compared(equal(f"{width} px: messages on the console", expected=[], got=messages))
            page.get_by_role("link", name="Results", exact=True).click()
            assert page.url.endswith("#results")
            page.close()
