"""HEAD wherever there is a GET: one mechanism, looked at over every route and a real connection."""

from collections.abc import Iterator

import httpx
import pytest

from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support.api import Api, SameFile, every_route, served
from tests.service.support.fakes import wait_until

ENDLESS = "/v1/queue/events"
# Headers of one response alone: its id, when it was sent, and how a body is framed that has no known length.
OF_ONE = {"x-request-id", "date", "transfer-encoding"}
MOVING = {"/metrics"}  # its content has another length each time
# Values of the other parameters of routes.
OTHERS = {"name": "result.json", "view": "film", "scenario": "thin_plate", "table": "holes"}


def paths(api: Api) -> Iterator[str]:
    """The path of each GET, with a sweep and a run that are there."""
    id = api.submit()
    api.compute()
    run = api.store.sweeps.points(id).items[0].run.id
    for route in every_route():
        if "GET" in (route.methods or ()):
            named = run if "/runs/" in route.path else id
            names = OTHERS | {"name": "energy"} if "/histories/" in route.path else OTHERS
            yield route.path.format(id=named, **names)
    yield "/static/style.css"


@pytest.mark.claim("pages", "head-where-get")
def test_head__is_what_get_says_without_its_body(api: Api, compared: Compared) -> None:
    """Every route with GET responds to HEAD with the same status and headers, and no body."""
    api.http.app.state.conversions = SameFile(api.settings.data / "cache")  # type: ignore[attr-defined]
    streams = api.http.app.state.event_streams  # type: ignore[attr-defined]
    routes = list(paths(api))
    assert len(routes) > 20
    with served(api) as url, httpx.Client(base_url=url, timeout=20.0) as http:
        http.get("/login")  # a browser has its cookie before it is compared
        for path in routes:
            head = http.head(path)
            assert head.content == b""
            if path == ENDLESS:
                assert head.headers["content-type"].startswith("text/event-stream")
                wait_until(lambda: streams.opened.total() == 0)  # no stream goes on for nobody
                continue
            compared(equal(path, expected=said(http.get(path)), got=said(head)))
        for path in ("/v1/sweeps/0", "/v1/sweeps/0/cancel", "/nowhere"):
            assert said(http.head(path)) == said(http.get(path))
        head = http.head("/v1/sweeps/0/cancel")
        assert (head.status_code, head.headers["allow"]) == (405, "POST")


def said(response: httpx.Response) -> tuple[int, dict[str, str]]:
    """Status and headers of a response that another one of the same request has too."""
    other = {"content-length"} if response.url.path in MOVING or response.is_error else set()
    return response.status_code, {name: value for name, value in response.headers.items() if name not in OF_ONE | other}
