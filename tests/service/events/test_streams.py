"""Event streams: nothing missed, nothing twice, progress at its pace, and nothing left behind."""

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import httpx
import pytest

from service.api.browsers import SESSION
from service.api.errors import TooManyRequests
from service.client.connection import ServerEvent, server_events
from service.events.streams import EventStreams
from service.records.jobs import AttemptProgress, Scope, StoreUnavailable
from service.settings import Settings
from tests.service.support.api import Api, served
from tests.service.support.fakes import wait_until

TIMEOUT = 60.0  # s, for a message on a busy machine


@contextmanager
def listening(url: str, path: str, last: int | None = None) -> Iterator[Iterator[ServerEvent]]:
    headers = {} if last is None else {"Last-Event-ID": str(last)}
    with httpx.stream("GET", url + path, headers=headers, timeout=TIMEOUT) as response:
        assert response.status_code == 200, response.read()
        yield server_events(response.iter_lines())


def whole_stream(api: Api, path: str, last: int | None = None, **query: Any) -> list[ServerEvent]:
    """Every message of a stream that ends by itself."""
    headers = {} if last is None else {"Last-Event-ID": str(last)}
    response = api.http.get(path, headers=headers, params=query)
    assert response.headers["Content-Type"].startswith("text/event-stream")
    return list(server_events(response.text.split("\n")))


def content(event: ServerEvent) -> Any:
    return json.loads(event.data)


def kinds(events: list[ServerEvent]) -> list[str]:
    return [content(event)["kind"] for event in events if event.name == "message"]


def test_sweep__that_has_ended_is_told_whole_and_then_ends(api: Api) -> None:
    here = f"/v1/sweeps/{api.submit()}/events"
    api.compute()
    whole = whole_stream(api, here)
    told = kinds(whole)
    assert (told[0], told.count("started"), told.count("succeeded"), told[-1]) == ("accepted", 3, 2, "published")
    end = whole[-1]
    assert (end.name, end.id, content(end)["state"]) == ("end", None, "succeeded")
    numbers = [int(event.id) for event in whole if event.id is not None]
    assert numbers == sorted(set(numbers))
    for place, number in enumerate(numbers):
        rest = whole_stream(api, here, last=number)
        assert rest == whole[place + 1 :]
        assert whole_stream(api, here, after=number) == rest


def test_sweep__of_more_events_than_a_page_is_told_whole(api: Api, monkeypatch: pytest.MonkeyPatch) -> None:
    here = f"/v1/sweeps/{api.submit(axes={'speed': ['3 km/s', '4 km/s', '5 km/s', '6 km/s']})}/events"
    api.compute()
    whole = whole_stream(api, here)
    monkeypatch.setattr("service.events.streams.PAGE", 4)
    assert whole_stream(api, here) == whole


def test_sweep__that_is_deleted_ends(api: Api) -> None:
    id = api.submit()
    with served(api) as url, listening(url, f"/v1/sweeps/{id}/events") as stream:
        assert content(next(stream))["kind"] == "accepted"
        api.store.sweeps.cancel(id)
        api.store.sweeps.delete(id)
        *_, end = stream
    assert end.name == "end"
    assert content(end)["state"] in ("cancelled", "deleted")


def test_queue__is_told_from_now_on_and_does_not_end(api: Api) -> None:
    api.submit()
    api.compute()
    beyond = api.store.events.last() + 1000
    with served(api) as url:
        for last in (None, beyond):
            with listening(url, "/v1/queue/events", last=last) as stream:
                api.http.post("/v1/queue/pause")
                api.http.post("/v1/queue/resume")
                assert [content(next(stream))["kind"] for _ in range(2)] == ["paused", "resumed"]
        with listening(url, "/v1/queue/events", last=0) as stream:
            assert content(next(stream))["kind"] == "accepted"


def test_progress__tells_time_step_and_the_value_so_far(api: Api) -> None:
    id = api.submit()
    [lease] = api.store.leases.take(1, api.term())
    report: AttemptProgress = {
        "time": 7e-6,
        "end_time": 1e-4,
        "step": 7,
        "eta_seconds": 5.0,
        "measured": {"hole_diameter": 0.01007},
    }
    with served(api) as url, listening(url, f"/v1/sweeps/{id}/events") as stream:
        api.store.leases.record_progress([(lease, {"fraction": 0.07, "seconds": 0.7, **report})])
        progress = next(event for event in stream if event.name == "progress")
    assert progress.id is None
    told = content(progress)
    assert {name: told[name] for name in report} == report
    assert told["run_id"] == lease.id


@pytest.fixture(params=["sweeps", "runs"])
def ended(request: pytest.FixtureRequest, api: Api) -> str:
    """The address of a sweep or a run that has ended."""
    sweep = api.submit()
    run = api.store.sweeps.points(sweep).items[0].run.id
    api.compute()
    return f"/v1/{request.param}/{sweep if request.param == 'sweeps' else run}"


def test_history__has_the_same_events_in_pages(api: Api, ended: str) -> None:
    past: list[dict[str, Any]] = []
    there: str | None = f"{ended}/history?limit=2"
    while there is not None:
        page = api.http.get(there)
        past += page.json()["items"]
        there = page.links.get("next", {}).get("url")
    assert past == [content(event) for event in whole_stream(api, f"{ended}/events") if event.id is not None]


@pytest.mark.parametrize("last", ["x", "-1", "1" * 19, "²", "1.5"])
def test_stream__behind_what_is_no_event_is_refused(api: Api, last: str) -> None:
    refused = api.http.get(f"/v1/sweeps/{api.submit()}/events", params={"after": last})
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["field"] == "Last-Event-ID"


def streams_of(api: Api) -> EventStreams:
    return api.http.app.state.event_streams  # type: ignore[attr-defined]


def test_listeners__are_bounded_and_leave_nothing_behind(api: Api) -> None:
    here = f"/v1/sweeps/{api.submit()}/events"
    streams_of(api)._most = 2
    with served(api) as url:
        with listening(url, here) as stream, listening(url, "/v1/queue/events", last=0) as other:
            next(stream)
            next(other)
            assert streams_of(api).opened.total() == 2
            refused = httpx.get(url + here, timeout=TIMEOUT)
            assert refused.status_code == 503
            assert refused.json()["type"].endswith("busy")
            assert int(refused.headers["Retry-After"]) > 0
        wait_until(lambda: streams_of(api).opened.total() == 0)


def test_listeners__of_one_key_leave_room_for_others(shared_api: Api) -> None:
    streams = EventStreams(shared_api.store, most_of_a_key=2)

    with streams.listening("ann"), streams.listening("ann"):
        with pytest.raises(TooManyRequests, match="2 event streams of this key"), streams.listening("ann"):
            pass
        with streams.listening("bob"):
            assert streams.opened.total() == 3


def test_listeners__are_let_go_when_the_service_leaves(api: Api) -> None:
    id = api.submit()
    with served(api) as url, listening(url, f"/v1/sweeps/{id}/events") as stream:
        next(stream)
        streams_of(api).close()
        assert list(stream) == []
        assert httpx.get(f"{url}/v1/queue/events", timeout=TIMEOUT).status_code == 503


@pytest.mark.parametrize("path", ["/v1/queue/events", "/v1/sweeps/{id}/events"])
@pytest.mark.parametrize("has_session", [False, True])
def test_stream__ends_with_its_key(api: Api, path: str, has_session: bool) -> None:
    key, secret = api.store.keys.issue("anna", [Scope.READ])
    session = f"{SESSION}={api.store.keys.begin_session(key)}"
    header = {"Cookie": session} if has_session else {"Authorization": f"Bearer {secret}"}
    streams_of(api).check_interval = 0.0
    here = path.format(id=api.submit())
    with served(api) as url, httpx.stream("GET", url + here, headers=header, timeout=TIMEOUT) as response:
        lines = response.iter_lines()
        next(lines)
        api.store.keys.revoke(key.id)
        api.http.app.state.settings = Settings(data=api.settings.data, host="0.0.0.0")  # type: ignore[attr-defined]
        assert not any(line.startswith(": ping") for line in lines)  # which an idle stream sends


def test_listener__stays_while_the_store_is_away(api: Api, monkeypatch: pytest.MonkeyPatch) -> None:
    away, asked, plain = threading.Event(), threading.Event(), api.store.events.last

    def last_event() -> int:
        if away.is_set():
            asked.set()
            raise StoreUnavailable("the database is locked")
        return plain()

    monkeypatch.setattr(api.store.events, "last", last_event)
    id = api.submit()
    with served(api) as url, listening(url, f"/v1/sweeps/{id}/events") as stream:
        next(stream)
        away.set()
        assert asked.wait(TIMEOUT)
        api.compute()
        away.clear()
        assert list(stream)[-1].name == "end"
