"""The pages: what a person sees, and that nothing comes from another machine."""

import re
import xml.etree.ElementTree as ET
from html import unescape
from typing import Any

import pytest

from service.pages.grid import sheet_of
from service.pages.page_routes import head_links
from service.records.jobs import Keep
from tests.service.support.api import SWEEP, Api
from tests.service.support.rows import TERM

SCRIPT, VIEWS = ('<script src="/static/live.js" defer>', '<script src="/static/view.js" defer>')


ALUMINIUM = {**SWEEP["fixed"], "projectile": "al-6061-t6", "target": "al-6061-t6"}
FIXED = {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm"}


def token_of(api: Api, page: str) -> dict[str, str]:
    """The field of a form with the token of a page."""
    return dict(re.findall(r'name="(csrf_token)" value="(\w+)"', api.http.get(page).text)[:1])


def addresses(page: str) -> list[str]:
    """Every address on a page."""
    return [unescape(text) for text in re.findall(r'\s(?:href|src)="([^"]*)"', page)]


@pytest.mark.claim("pages", "links")
@pytest.mark.parametrize(
    "path",
    [
        "/",
        "/docs",
        "/sweeps/{id}",
        "/runs/{run}",
        "/new",
        "/scenarios",
        "/laws",
        "/shots",
        "/compare?sweep={id}&sweep={other}",
    ],
)
def test_page__needs_no_other_machine_and_has_no_dead_link(api: Api, path: str) -> None:
    """Every link of a page leads to a page."""
    id, other = api.submit(), api.submit(resolution=12)
    api.compute()
    run = api.store.sweeps.points(id).items[0].run.id
    response = api.http.get(path.format(id=id, run=run, other=other))
    assert response.headers["Content-Type"].startswith("text/html")
    assert response.headers["Content-Security-Policy"].startswith("default-src 'none'")
    assert re.findall("<script[^>]*>", response.text) in ([], [SCRIPT], [VIEWS])
    seen_from_the_first = {address for address, _ in head_links()} if path != "/" else set()
    for address in set(addresses(response.text)) - seen_from_the_first:
        assert re.match(r"/(?!/)|#|\?|data:(,$|image/svg)", address), address[:80]
        page, _, id = address.partition("#")
        if page.startswith("/"):
            assert api.http.get(page).status_code == 200, address
        if id:
            there = api.http.get(page).text if page else response.text
            assert f' id="{id}"' in there, address


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


def test_sweeps__print_what_a_user_wrote_as_text(api: Api) -> None:
    id = api.submit(title="<script>alert(1)</script>")
    for path in ("/", f"/sweeps/{id}"):
        page = api.http.get(path).text
        assert re.findall("<script[^>]*>", page) == [SCRIPT]
        assert "&lt;script&gt;" in page


def test_sweeps__rows_link_to_pages_and_files_for_people(api: Api) -> None:
    id = api.submit()
    api.compute()
    rows = api.http.get("/").text.partition("<tbody>")[2]
    here = f"/v1/sweeps/{id}"
    files = [f"{here}/{name}" for name in ("report.html", "appendix.html", "cube.nc", "runs.csv")]
    thumbnail, *others = addresses(rows)
    assert others == [f"/sweeps/{id}", *files]
    drawn = api.http.get(thumbnail)
    assert (drawn.headers["content-type"], "max-age" in drawn.headers["cache-control"]) == ("image/svg+xml", True)
    assert "Use the law; simulation only." in rows
    assert "speed 3 km/s, 6 km/s" in rows


def test_sweeps__are_in_the_order_of_a_column_and_filtered_by_others(api: Api) -> None:
    axes = {"speed": ["3 km/s", "4 km/s", "5 km/s"]}
    ids = [api.submit(title="b"), api.submit(title="a", axes=axes), api.submit(title="c", fixed=ALUMINIUM)]
    b, a, c = ids
    for query, expected in {
        "": [c, a, b],
        "?up=true": [b, a, c],
        "?order=title&up=true": [a, b, c],
        "?order=runs&show=1": [a],
        "?order=runs&show=1&first=1": [c],
        "?order=materials&up=true": [c, a, b],
        "?material=al-6061": [c],
        "?scenario=thin_plate&material=copper": [a, b],
        "?scenario=thick_plate": [],
    }.items():
        page = api.http.get(f"/{query}").text
        assert re.findall(r'class="sweep"><a href="/sweeps/(\w+)"', page) == expected, query
    assert 'aria-sort="ascending"' in api.http.get("/?order=title&up=true").text


def test_sweeps__of_one_title_are_told_apart_by_their_requests(api: Api) -> None:
    for resolution in (8, 12, 12):
        api.submit(title="holes", resolution=resolution)
    page = api.http.get("/").text
    assert re.findall('class="apart">(resolution [0-9]+) ', page) == ["resolution 12", "resolution 12", "resolution 8"]
    other = api.submit(title="alone")
    assert f"<code>{other[:8]}</code>" not in api.http.get("/").text


def test_comparison__sets_two_sweeps_beside_each_other(api: Api) -> None:
    first, second = api.submit(), api.submit(axes={"speed": ["6 km/s", "7 km/s"]}, resolution=12, title="B")
    api.compute()
    page = api.http.get(f"/compare?sweep={first}&sweep={second}").text
    differences = page.partition("In what they differ")[2].partition("What both measured")[0]
    assert re.findall("<td>(.*?)</td>", differences) == ["3 km/s, 6 km/s", "6 km/s, 7 km/s", "8", "12"]
    shared = page.partition("What both measured")[2]
    assert re.findall(r'<th scope="row">(.*?)</th>', shared) == ["6 km/s"]
    [chart] = [at for at in addresses(page) if "content=" in at]
    words = [*ET.fromstring(api.http.get(chart).text).itertext()]
    assert {"A", "B"} <= {*words}
    refused = api.http.get(f"/compare?sweep={first}")
    assert (refused.status_code, "tick two in the list" in refused.text) == (422, True)


@pytest.mark.parametrize(
    ("query", "found"),
    [
        *(("?q=COPP", True), ("?q=100%25", False), ("?state=queued", True), ("?state=failed", False)),
        *(("?q=holes+plate", True), ("?q=Perforation+of+a+plate", True), ("?q=Whipple+shield", False)),
        *(("?q=copper-ofhc", True), ("?q=plate+OFHC", True), ("?q=aluminium", False), ("?q=projectile", False)),
    ],
)
def test_sweeps__are_searched(api: Api, query: str, found: bool) -> None:
    id = api.submit(title="Holes in copper")
    page = api.http.get(f"/{query}").text
    assert (f"/sweeps/{id}" in page) is found
    assert ("No sweep is like that" in page) is not found


def test_sweep__is_a_grid_whose_cells_lead_to_the_runs(api: Api) -> None:
    id = api.submit(axes={"speed": ["3 km/s", "6 km/s"], "plate_thickness": ["2 mm", "3 mm", "4 mm"]}, fixed=FIXED)
    [first] = api.store.leases.take(1, api.term())
    api.store.leases.finish(first, api.result(first.id))
    page = api.http.get(f"/sweeps/{id}").text
    cells = re.findall(r'<td class="([^"]+)"><a href="/runs/(\w+)">([^<]+)</a>', page)
    runs = {point.index: point.run.id for point in api.store.sweeps.points(id).items}
    # Rows are the longer axis.
    assert [run for _, run, _ in cells] == [runs[speed, plate] for plate in range(3) for speed in range(2)]
    assert (cells[0][0], cells[0][2]) == ("succeeded v0", "14.80")
    assert {text for _, _, text in cells[1:]} == {"queued"}
    [chart] = [at for at in addresses(page) if "content=" in at]
    drawn = api.http.get(chart)
    assert drawn.headers["content-type"] == "image/svg+xml"
    assert "Hole diameter (mm)" in ET.fromstring(drawn.text).itertext()
    resolved = api.http.get(f"/sweeps/{id}?quantity=hole_diameter_lip&sheet=²").text
    assert "no value" in resolved


def test_layout__has_a_sheet_for_each_value_of_the_other_axes() -> None:
    axes: Any = {
        "speed": ["3 km/s", "6 km/s"],
        "geometry": ["half", "quarter"],
        "plate_thickness": ["1 mm", "2 mm", "3 mm"],
    }
    sheet = sheet_of({"axes": axes, "combine": "grid", "resolution": [8, 16], "offsets": 3}, 72, "", 0)
    assert sheet.shown == (2, 0)
    assert sheet.ordinals == [[3, 39], [9, 45], [15, 51]]
    assert [label for label, _ in sheet.others()] == ["geometry", "resolution", "grid offset"]
    sampled: Any = {"axes": {"speed": {"low": "3 km/s", "high": "6 km/s"}}, "combine": "sobol"}
    searched: Any = {"axes": {"speed": {"limit_of": "perforated"}, "nose": ["blunt", "conical"]}, "combine": "grid"}
    for document in (sampled, searched):
        assert sheet_of(document, 8, "", 0).ordinals == [[ordinal] for ordinal in range(8)]


def test_sweep__gets_further_values_in_their_order_and_computes_only_those(api: Api) -> None:
    id = api.submit()
    api.compute()
    form = {"axis": "speed", "values": "4 km/s, 5500 m/s", **token_of(api, f"/sweeps/{id}")}
    answer = api.http.post(f"/sweeps/{id}/values", data=form, follow_redirects=False)
    assert answer.status_code == 303, answer.text
    longer = answer.headers["Location"].removeprefix("/sweeps/")
    assert api.store.sweeps.document(longer)["axes"] == {"speed": ["3 km/s", "4 km/s", "5.5 km/s", "6 km/s"]}
    again = api.http.post(f"/sweeps/{id}/values", data=form, follow_redirects=False)
    assert again.headers["Location"] == answer.headers["Location"]
    other = api.http.post(f"/sweeps/{id}/values", data={**form, "once": "another page"}, follow_redirects=False)
    assert other.headers["Location"] != answer.headers["Location"]
    status = api.store.sweeps.get(longer)
    assert (status.planned, status.reused, status.new) == (4, 2, 2)
    refused = api.http.post(f"/sweeps/{id}/values", data={**form, "values": "3 mm"}, headers={"Accept": "text/html"})
    assert refused.status_code == 422
    assert "speed" in refused.text


def test_run__that_kept_no_film_is_computed_again_alone(api: Api) -> None:
    id = api.submit(resolution=[8, 12], offsets=2)
    api.compute()
    run = api.store.sweeps.points(id).items[-1].run.id
    page = f"/runs/{run}"
    answer = api.http.post(f"{page}/film", data=token_of(api, f"/sweeps/{id}"), follow_redirects=False)
    assert (answer.status_code, answer.headers.get("Location")) == (303, page), answer.text
    film = api.store.runs.places(run, 1)[0]
    assert film.title == "Film of a run of two-speeds"
    assert [point.run.id for point in api.store.sweeps.points(film.sweep_id).items] == [run]
    assert api.store.sweeps.get(film.sweep_id).keep is Keep.FILM
    [lease] = api.store.leases.take(5, TERM + 1)
    assert (lease.id, lease.keep) == (run, Keep.FILM)
    sent_again: dict[str, Any] = {"data": token_of(api, f"/sweeps/{id}"), "follow_redirects": False}
    assert api.http.post(f"{page}/film", **sent_again).status_code == 303
    api.compute()
    assert api.store.runs.places(run, 1)[0].sweep_id == film.sweep_id
    # A run that still has no film is computed again, under the same title.
    api.http.post(f"{page}/film", **sent_again)
    assert api.store.runs.places(run, 1)[0].title == film.title


def test_sweep__with_a_failed_run_offers_to_retry_it(api: Api) -> None:
    id = api.submit()
    api.compute(failures=1)
    page = api.http.get(f"/sweeps/{id}").text
    assert 'class="failed"' in page
    assert f'action="/sweeps/{id}/retry"' in page
    api.http.post(f"/sweeps/{id}/retry", data=token_of(api, f"/sweeps/{id}"))
    api.compute()
    assert f'action="/sweeps/{id}/retry"' not in api.http.get(f"/sweeps/{id}").text


def test_browser__gets_a_page_and_a_program_the_document(shared_api: Api) -> None:
    path = f"/sweeps/{'0' * 32}"
    page = shared_api.http.get(path, headers={"Accept": "text/html,application/xhtml+xml,*/*;q=0.8"})
    assert (page.status_code, page.headers["content-type"]) == (404, "text/html; charset=utf-8")
    assert "<h1>Not found</h1>" in page.text
    assert "style-src 'self'" in page.headers["content-security-policy"]
    document = shared_api.http.get(path)
    assert document.headers["content-type"] == "application/problem+json"
    assert page.headers["vary"] == document.headers["vary"] == "Accept"
