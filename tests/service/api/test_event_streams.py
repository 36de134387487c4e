"""Event streams: nothing missed, nothing twice, progress at its pace, and nothing left behind."""

import asyncio
import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import pytest

from service.api.errors import TooManyRequests
from service.api.event_streams import EventStreams
from service.records.jobs import Lease, StoreUnavailable
from tests.service.support.api import Api, open_api, served
from tests.service.support.fakes import wait_until

TIMEOUT = 60.0  # s, for a message on a busy machine


@dataclass(frozen=True)
class Message:
    """One message of a stream."""

    name: str  # "" for an event of the store
    id: int | None
    data: Any


@pytest.fixture
def api(tmp_path: Path) -> Iterator[Api]:
    with open_api(tmp_path) as opened:
        yield opened


@contextmanager
def listening(url: str, path: str, last: int | None = None) -> Iterator[Iterator[Message]]:
    """The messages of a stream, over a real connection."""
    headers = {} if last is None else {"Last-Event-ID": str(last)}
    with httpx.stream("GET", url + path, headers=headers, timeout=TIMEOUT) as response:
        assert response.status_code == 200, response.read()
        yield messages(response.iter_lines())


def messages(lines: Iterator[str]) -> Iterator[Message]:
    """Messages from lines, as a browser reads them; comments and ``retry`` are none."""
    result: dict[str, str] = {}
    for line in lines:
        if line:
            key, _, value = line.partition(": ")
            result[key] = value
            continue
        if "data" in result:
            number = int(result["id"]) if "id" in result else None
            yield Message(result.get("event", ""), number, json.loads(result["data"]))
        result = {}


def whole_stream(api: Api, path: str, last: int | None = None) -> list[Message]:
    """Every message of a stream that ends by itself."""
    headers = {} if last is None else {"Last-Event-ID": str(last)}
    response = api.http.get(path, headers=headers)
    assert response.headers["Content-Type"].startswith("text/event-stream")
    return list(messages(iter(response.text.split("\n"))))


def report_progress(api: Api, claim: Lease, step: int) -> None:
    """Say how far a run is, as the dispatcher does."""
    progress = {"time": 1e-6 * step, "end_time": 1e-4, "step": step, "eta_seconds": 5.0}
    progress["measured"] = {"hole_diameter": 0.01 + 1e-5 * step}  # type: ignore[assignment]
    api.store.record_progress([(claim, step / 100, 0.1 * step, progress)])


# --- what is told ---------------------------------------------------------------------------------


def test_sweep__that_has_ended_is_told_whole_and_then_ends(api: Api) -> None:
    id = api.submit()
    api.compute()
    messages = whole_stream(api, f"/v1/sweeps/{id}/events")
    kinds = [message.data["kind"] for message in messages[:-1]]
    assert kinds[0] == "accepted"
    assert kinds.count("started") == 3
    assert kinds.count("succeeded") == 2
    assert kinds[-1] == "published"
    assert (messages[-1].name, messages[-1].id, messages[-1].data["state"]) == ("end", None, "succeeded")


def test_sweep__goes_on_behind_the_last_event_that_was_seen(api: Api) -> None:
    id = api.submit()
    api.compute()
    whole = whole_stream(api, f"/v1/sweeps/{id}/events")
    numbers = [message.id for message in whole if message.id is not None]
    assert numbers == sorted(set(numbers))
    for place, number in enumerate(numbers):
        rest = whole_stream(api, f"/v1/sweeps/{id}/events", last=number)
        assert rest == whole[place + 1 :]
        asked = api.http.get(f"/v1/sweeps/{id}/events?after={number}").text
        assert list(messages(iter(asked.split("\n")))) == rest


def test_sweep__of_more_events_than_a_page_is_told_whole(api: Api, monkeypatch: pytest.MonkeyPatch) -> None:
    id = api.submit(axes={"speed": {"start": "3 km/s", "stop": "6 km/s", "step": "0.5 km/s"}})
    api.compute()
    whole = whole_stream(api, f"/v1/sweeps/{id}/events")
    monkeypatch.setattr("service.api.event_streams.PAGE", 4)
    assert whole_stream(api, f"/v1/sweeps/{id}/events") == whole


def test_sweep__is_told_as_it_happens(api: Api) -> None:
    id = api.submit()
    with served(api) as url, listening(url, f"/v1/sweeps/{id}/events") as stream:
        assert next(stream).data["kind"] == "accepted"
        api.compute()
        rest = list(stream)
    assert rest[-2].data["kind"] == "published"
    assert rest[-1].name == "end"
    assert {message.data["run_id"] for message in rest if message.data.get("kind") == "started"}


def test_sweep__that_is_deleted_ends(api: Api) -> None:
    id = api.submit()
    with served(api) as url, listening(url, f"/v1/sweeps/{id}/events") as stream:
        assert next(stream).data["kind"] == "accepted"
        api.store.cancel_sweep(id)
        api.store.delete_sweep(id)
        rest = list(stream)
    assert rest[-1].name == "end"
    assert rest[-1].data["state"] in ("cancelled", "deleted")


def test_queue__is_told_from_now_on_and_does_not_end(api: Api) -> None:
    api.submit()
    api.compute()
    with served(api) as url:
        with listening(url, "/v1/queue/events") as stream:
            api.http.post("/v1/queue/pause")
            api.http.post("/v1/queue/resume")
            assert [next(stream).data["kind"] for _ in range(2)] == ["paused", "resumed"]
        with listening(url, "/v1/queue/events", last=0) as stream:
            assert next(stream).data["kind"] == "accepted"


def test_progress__tells_time_step_and_the_value_so_far(api: Api) -> None:
    id = api.submit()
    [claim] = api.store.lease(1, api.term())
    with served(api) as url, listening(url, f"/v1/sweeps/{id}/events") as stream:
        report_progress(api, claim, 7)
        progress = next(message for message in stream if message.name == "progress")
    assert progress.id is None
    assert progress.data["run_id"] == claim.id
    assert progress.data["step"] == 7
    assert progress.data["eta_seconds"] == 5.0
    assert progress.data["measured"] == {"hole_diameter": pytest.approx(0.01007)}


# --- the same as pages ------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["sweeps", "runs"])
def test_history__has_the_same_events_in_pages(api: Api, kind: str) -> None:
    sweep = api.submit()
    run = api.store.sweep_runs(sweep).items[0].run.id
    api.compute()
    here = f"/v1/{kind}/{sweep if kind == 'sweeps' else run}"
    stream = whole_stream(api, f"{here}/events")
    messages: list[dict[str, Any]] = []
    there: str | None = f"{here}/history?limit=2"
    while there is not None:
        answer = api.http.get(there)
        messages += answer.json()["items"]
        there = answer.links.get("next", {}).get("url")
    assert messages == [message.data for message in stream if message.id is not None]


# --- what it costs ----------------------------------------------------------------------------------


def streams_of(api: Api) -> EventStreams:
    return api.http.app.state.event_streams  # type: ignore[attr-defined]


def reading_threads() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name == "event-streams"]


def test_listener__that_goes_away_leaves_nothing_behind(api: Api) -> None:
    id = api.submit()
    with served(api) as url:
        for _ in range(3):
            with listening(url, f"/v1/sweeps/{id}/events") as stream:
                next(stream)
                assert streams_of(api).open == 1
                assert len(reading_threads()) == 1
            wait_until(lambda: streams_of(api).open == 0)
        wait_until(lambda: not reading_threads())


def test_listeners__are_bounded(api: Api) -> None:
    id = api.submit()
    streams_of(api)._most = 2
    with (
        served(api) as url,
        listening(url, f"/v1/sweeps/{id}/events") as item,
        listening(url, "/v1/queue/events", last=0) as other,
    ):
        next(item)
        next(other)
        assert len(reading_threads()) == 1
        refused = httpx.get(f"{url}/v1/sweeps/{id}/events", timeout=TIMEOUT)
        assert refused.status_code == 503
        assert refused.json()["type"].endswith("busy")
        assert int(refused.headers["Retry-After"]) > 0


def test_listeners__of_one_key_leave_room_for_others(api: Api) -> None:
    streams = EventStreams(api.store, most_of_a_key=2)

    async def listen() -> None:
        async with streams.listening("ann"), streams.listening("ann"):
            with pytest.raises(TooManyRequests, match="2 event streams of this key"):
                async with streams.listening("ann"):
                    pass
            async with streams.listening("bob"):
                assert streams.open == 3

    asyncio.run(listen())
    streams.close()


def test_listeners__are_let_go_when_the_service_leaves(api: Api) -> None:
    id = api.submit()
    with served(api) as url, listening(url, f"/v1/sweeps/{id}/events") as stream:
        next(stream)
        streams_of(api).close()
        assert list(stream) == []
        assert httpx.get(f"{url}/v1/queue/events", timeout=TIMEOUT).status_code == 503
    wait_until(lambda: not reading_threads())


def test_listener__stays_while_the_store_is_away(api: Api, monkeypatch: pytest.MonkeyPatch) -> None:
    id = api.submit()
    away = threading.Event()
    asked = threading.Event()
    plain = api.store.last_event

    def last_event() -> int:
        if away.is_set():
            asked.set()
            raise StoreUnavailable("the database is locked")
        return plain()

    monkeypatch.setattr(api.store, "last_event", last_event)
    with served(api) as url, listening(url, f"/v1/sweeps/{id}/events") as stream:
        next(stream)
        away.set()
        assert asked.wait(TIMEOUT)
        api.compute()
        away.clear()
        assert list(stream)[-1].name == "end"


@pytest.mark.parametrize("path", ["/v1/sweeps/{}/events", "/v1/runs/{}/events", "/v1/runs/{}/history"])
def test_stream__of_nothing_is_a_404(api: Api, path: str) -> None:
    assert api.http.get(path.format("0" * 32)).status_code == 404
    assert streams_of(api).open == 0


@pytest.mark.parametrize("kind", ["sweeps", "runs"])
def test_stream__behind_an_event_that_is_not_there_yet_begins_anew(api: Api, kind: str) -> None:
    sweep = api.submit()
    run = api.store.sweep_runs(sweep).items[0].run.id
    api.compute()
    path = f"/v1/{kind}/{sweep if kind == 'sweeps' else run}/events"
    whole, last = whole_stream(api, path), api.store.last_event()
    assert whole_stream(api, path, last=last) == whole[-1:]  # its end alone
    for beyond in (last + 1, 10**17):  # it was seen before a backup was restored
        assert whole_stream(api, path, last=beyond) == whole


def test_queue__behind_an_event_that_is_not_there_yet_is_told_from_now_on(api: Api) -> None:
    api.submit()
    beyond = api.store.last_event() + 1000
    with served(api) as url, listening(url, "/v1/queue/events", last=beyond) as stream:
        api.http.post("/v1/queue/pause")
        assert next(stream).data["kind"] == "paused"


@pytest.mark.parametrize("last", ["x", "-1", "1" * 19, "²", "1.5"])
def test_stream__behind_what_is_no_event_is_refused(api: Api, last: str) -> None:
    id = api.submit()
    refused = api.http.get(f"/v1/sweeps/{id}/events", params={"after": last})
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["field"] == "Last-Event-ID"
