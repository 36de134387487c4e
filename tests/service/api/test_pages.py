"""The pages: what a person sees, and that nothing comes from another machine."""

import re
from html.parser import HTMLParser

import pytest

from service.api.errors import PROBLEMS
from service.api.pages.rendering import PAGES
from tests.service.support.api import Api

SCRIPT = '<script src="/static/live.js" defer>'


class Links(HTMLParser):
    """Every address on a page, and every id."""

    def __init__(self, page: str):
        super().__init__()
        self.addresses: list[str] = []
        self.ids: set[str] = set()
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name in ("href", "src"):
                self.addresses.append(value or "")
            if name == "id":
                self.ids.add(value or "")


@pytest.mark.parametrize("path", ["/", "/docs", "/sweeps/{id}"])
def test_page__needs_no_other_machine_and_has_no_dead_link(api: Api, path: str) -> None:
    id = api.submit()
    api.compute()
    response = api.http.get(path.format(id=id))
    assert response.headers["Content-Type"].startswith("text/html")
    assert response.headers["Content-Security-Policy"].startswith("default-src 'none'")
    assert re.findall("<script[^>]*>", response.text) in ([], [SCRIPT])
    links = Links(response.text)
    seen_from_the_first = {address for address, _ in PAGES} if path != "/" else set()
    for address in set(links.addresses) - seen_from_the_first:
        assert re.match(r"/(?!/)|#|data:,$", address), address
        page, _, id = address.partition("#")
        if page.startswith("/"):
            assert api.http.get(page).status_code == 200, address
        if id:
            there = Links(api.http.get(page).text) if page else links
            assert id in there.ids, address


def test_sweeps__show_state_progress_and_results(api: Api) -> None:
    id = api.submit()
    waiting = api.http.get("/").text
    assert "queued" in waiting
    assert "cube.nc" not in waiting
    api.compute(failures=1)
    done = api.http.get("/").text
    assert f"/v1/sweeps/{id}/report.html" in done
    assert f"/v1/sweeps/{id}/cube.nc" in done
    assert "1 failed" in done


def test_sweep__shows_the_headline_of_the_report(api: Api) -> None:
    page = f"/sweeps/{api.submit()}"
    waiting = api.http.get(page).text
    assert "queued" in waiting
    assert f'data-events="/v1{page}/events"' in waiting
    assert "Use the law" not in waiting
    api.compute()
    done = api.http.get(page).text
    assert '<p class="headline">Use the law; simulation only.</p>' in done
    assert "data-events" not in done


def test_sweeps__say_why_nothing_is_begun(api: Api) -> None:
    api.submit()
    assert "no run starts" not in api.http.get("/").text.lower()
    api.http.post("/v1/queue/pause")
    api.store.queue.set_blocked_reason("the scheduler <is> away")
    page = api.http.get("/").text
    assert "The queue has been paused since" in page
    assert "the scheduler &lt;is&gt; away" in page


def test_sweeps__print_what_a_user_wrote_as_text(api: Api) -> None:
    id = api.submit(title="<script>alert(1)</script>")
    for path in ("/", f"/sweeps/{id}"):
        page = api.http.get(path).text
        assert re.findall("<script[^>]*>", page) == [SCRIPT]
        assert "&lt;script&gt;" in page


def test_docs__list_every_operation_and_every_problem(shared_api: Api) -> None:
    page = shared_api.http.get("/docs").text
    for path, methods in shared_api.http.get("/openapi.json").json()["paths"].items():
        for method in methods:
            assert f"{method.upper()} {path}" in page
    for problem in PROBLEMS.values():
        assert f'id="problem-{problem.slug}"' in page


LIGHT, DARK = "#ffffff", "#1e1e1e"  # pages have the canvas of the browser; no dark one is lighter
ENOUGH = 4.5  # WCAG 2.2, success criterion 1.4.3


def luminance(colour: str) -> float:
    """Relative luminance (WCAG 2.2)."""
    shares = [int(colour[place : place + 2], 16) / 255 for place in (1, 3, 5)]
    linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in shares]
    return float(0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2])


def test_colours__of_words_have_contrast_in_the_light_and_in_the_dark(shared_api: Api) -> None:
    sheet = shared_api.http.get("/static/style.css").text
    light, dark = (
        dict(re.findall(r"--(\w+): (#[0-9a-f]{6});", block)) for block in re.findall(r":root \{([^}]*)\}", sheet)
    )
    assert light.keys() == dark.keys() >= {"accent", "quiet", "good", "bad", "open"}
    assert not re.findall(r"(?<![-\w])color: #", sheet)
    for colours, canvas in ((light, LIGHT), (dark, DARK)):
        for name, colour in colours.items():
            low, high = sorted((luminance(colour), luminance(canvas)))
            assert (high + 0.05) / (low + 0.05) >= ENOUGH, (name, colour, canvas)
