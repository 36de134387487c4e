"""The queue as a whole, health and what a monitor reads."""

import re
import shutil
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
from prometheus_client.parser import text_string_to_metric_families

from service.api.routes import health
from service.records.jobs import State, StoreUnavailable
from tests.service.support.api import Api, open_api
from tests.service.support.fakes import DEADLINE


@pytest.fixture
def api(tmp_path: Path) -> Iterator[Api]:
    with open_api(tmp_path) as opened:
        yield opened


# --- queue ----------------------------------------------------------------------------------------


def test_queue__says_what_is_in_it_and_who_works_through_it(api: Api) -> None:
    api.submit()
    queue = api.http.get("/v1/queue").json()
    assert (queue["counts"]["queued"], queue["counts"]["waiting"]) == (2, 1)
    assert (queue["paused"], queue["leader"]) == (None, None)
    assert queue["oldest_queued"] is not None
    api.term()
    assert api.http.get("/v1/queue").json()["leader"] == "tests"


def test_queue__gives_the_reason_that_readiness_gives(api: Api) -> None:
    assert api.http.get("/v1/queue").json()["blocked_reason"] == not_ready(api)
    api.term()
    api.engine.reason = "there is no worker today"
    api.http.app.state.readiness = health.ReadinessCheck()  # type: ignore[attr-defined]
    assert api.http.get("/v1/queue").json()["blocked_reason"] == "there is no worker today"
    assert not_ready(api) == "there is no worker today"


def test_queue__counts_jobs_once_while_nothing_happens(api: Api) -> None:
    """And anew after each event."""
    api.submit()
    counted: list[str] = []
    engine = api.store._database._engine

    @sa.event.listens_for(engine, "before_cursor_execute")
    def note(_c: Any, _cursor: Any, statement: str, *_rest: Any) -> None:
        if "GROUP BY jobs.state" in statement:
            counted.append(statement)

    for _ in range(20):
        assert api.store.queue().states[State.QUEUED] == 2
    assert len(counted) <= 3  # another one every half a second
    api.store.lease(1, api.term())
    assert api.store.queue().states[State.RUNNING] == 1


def test_pause__begins_no_runs_until_resume(api: Api) -> None:
    api.submit()
    paused = api.http.post("/v1/queue/pause")
    assert paused.status_code == 200
    assert paused.json()["paused"] is not None
    assert "resume" in paused.json()["links"]
    assert api.store.lease(10, api.term()) == ()
    assert api.http.post("/v1/queue/pause").json()["paused"] == paused.json()["paused"]
    assert api.http.post("/v1/queue/resume").json()["paused"] is None
    assert len(api.store.lease(10, api.term())) == 2


# --- health ---------------------------------------------------------------------------------------


def not_ready(api: Api) -> str:
    response = api.http.get("/readyz")
    assert response.status_code == 503
    assert response.headers["Content-Type"] == "application/problem+json"
    assert int(response.headers["Retry-After"]) > 0
    assert api.http.get("/livez").status_code == 200
    return response.json()["detail"]


def test_readyz__says_what_was_looked_at(api: Api) -> None:
    api.term()
    answer = api.http.get("/readyz").json()
    assert answer["status"] == "ready"
    assert set(answer["checks"]) == {"store", "data", "disk", "leader", "workers"}


def test_readyz__needs_a_store_that_can_be_written(api: Api, monkeypatch: pytest.MonkeyPatch) -> None:
    def ping() -> None:
        raise StoreUnavailable("the database is locked")

    monkeypatch.setattr(api.store, "ping", ping)
    assert "locked" in not_ready(api)


def test_readyz__needs_a_data_directory(api: Api) -> None:
    api.term()
    hidden = api.settings.data.with_name("hidden")
    api.settings.data.rename(hidden)
    try:
        assert "data directory" in not_ready(api)
    finally:
        shutil.rmtree(api.settings.data, ignore_errors=True)
        hidden.rename(api.settings.data)


def test_readyz__takes_the_write_lock_once_a_second_however_often_it_is_asked(
    api: Api, monkeypatch: pytest.MonkeyPatch
) -> None:
    pings: list[None] = []
    monkeypatch.setattr(api.store, "ping", lambda: pings.append(None))
    monkeypatch.setattr(health, "REUSE_SECONDS", DEADLINE)
    for _ in range(3):
        assert "no service leads" in not_ready(api)
    assert len(pings) == 1
    monkeypatch.setattr(health, "REUSE_SECONDS", 0.0)
    not_ready(api)
    assert len(pings) == 2


def test_readyz__does_not_wait_for_a_store_that_does_not_answer(api: Api, monkeypatch: pytest.MonkeyPatch) -> None:
    pings: list[None] = []
    goes_on = threading.Event()

    def ping() -> None:
        pings.append(None)
        assert goes_on.wait(DEADLINE)

    api.term()
    monkeypatch.setattr(api.store, "ping", ping)
    monkeypatch.setattr(health, "TIMEOUT_SECONDS", 0.01)
    try:
        for _ in range(2):
            assert "has not responded" in not_ready(api)
    finally:
        goes_on.set()
    assert len(pings) == 1
    monkeypatch.setattr(health, "TIMEOUT_SECONDS", DEADLINE)
    assert api.http.get("/readyz").status_code == 200


def test_readyz__needs_the_disk_reserve(tmp_path: Path) -> None:
    with open_api(tmp_path, disk_reserve=1 << 60) as api:
        api.term()
        assert "reserve" in not_ready(api)


# --- metrics --------------------------------------------------------------------------------------


def measured(api: Api) -> dict[tuple[str, frozenset[tuple[str, str]]], float]:
    """Every sample by name and labels."""
    response = api.http.get("/metrics")
    assert response.headers["Content-Type"].startswith("text/plain")
    return {
        (sample.name, frozenset(sample.labels.items())): sample.value
        for family in text_string_to_metric_families(response.text)
        for sample in family.samples
    }


def sample(result: dict[Any, float], name: str, **labels: str) -> float:
    return result[(name, frozenset(labels.items()))]


def test_metrics__count_runs_and_publications_by_state(api: Api) -> None:
    api.submit()
    result = measured(api)
    assert sample(result, "whipple_runs", state="queued") == 2
    assert sample(result, "whipple_runs", state="failed") == 0
    assert sample(result, "whipple_publications", state="waiting") == 1
    api.compute(failures=1)
    result = measured(api)
    assert sample(result, "whipple_runs", state="succeeded") == 1
    assert sample(result, "whipple_runs", state="failed") == 1
    assert sample(result, "whipple_attempts_failed_total", cause="error") == 1
    assert sample(result, "whipple_attempts_failed_total", cause="crash") == 0


def test_metrics__have_seconds_of_runs_as_a_histogram(api: Api) -> None:
    api.submit()
    api.compute()  # a second each
    result = measured(api)
    assert sample(result, "whipple_run_seconds_bucket", le="1.0") == 2
    assert sample(result, "whipple_run_seconds_bucket", le="+Inf") == 2
    assert sample(result, "whipple_run_seconds_count") == 2
    assert sample(result, "whipple_run_seconds_sum") == 2.0


def test_metrics__say_how_long_the_queue_is_and_who_leads(api: Api) -> None:
    api.submit()
    result = measured(api)
    assert 0 <= sample(result, "whipple_queue_age_seconds") < 60
    assert sample(result, "whipple_queue_paused") == 0
    assert (sample(result, "whipple_slots"), sample(result, "whipple_leader")) == (2, 1)
    api.http.post("/v1/queue/pause")
    api.engine.slots = None
    result = measured(api)
    assert sample(result, "whipple_queue_paused") == 1
    assert (sample(result, "whipple_slots"), sample(result, "whipple_leader")) == (0, 0)


def test_metrics__count_requests_by_template_and_never_by_what_a_user_wrote(api: Api) -> None:
    id = api.submit()
    for path in (f"/v1/sweeps/{id}", "/v1/sweeps/nope", "/v1/nowhere/else", "/static/style.css"):
        api.http.get(path)
    api.http.request("BREW", "/v1/sweeps")
    result = measured(api)
    count = "whipple_http_requests_total"
    template = "/v1/sweeps/{id}"
    assert sample(result, count, route=template, method="GET", status="200") == 1
    assert sample(result, count, route=template, method="GET", status="404") == 1
    assert sample(result, count, route="/v1/sweeps", method="POST", status="202") == 1
    assert sample(result, count, route="unknown", method="GET", status="404") == 1
    assert sample(result, count, route="/static", method="GET", status="200") == 1
    assert sample(result, count, route="/v1/sweeps", method="other", status="405") == 1
    assert sample(result, "whipple_http_request_seconds_count", route=template, method="GET") == 2
    text = api.http.get("/metrics").text
    assert not re.search(r"nope|BREW|nowhere|" + id, text)


def test_metrics__without_a_store_still_say_what_they_know(api: Api, monkeypatch: pytest.MonkeyPatch) -> None:
    assert sample(measured(api), "whipple_store_up") == 1

    def queue() -> None:
        raise StoreUnavailable("the database is away")

    monkeypatch.setattr(api.store, "queue", queue)
    result = measured(api)
    assert sample(result, "whipple_store_up") == 0
    assert sample(result, "whipple_slots") == 2
