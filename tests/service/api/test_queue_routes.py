"""The queue as a whole, and health."""

import threading

import pytest

from service.api import readiness
from tests.service.support.api import Api
from tests.service.support.fakes import DEADLINE


def test_queue__says_what_is_in_it_and_who_works_through_it(api: Api) -> None:
    api.submit()
    queue = api.http.get("/v1/queue").json()
    assert (queue["counts"]["queued"], queue["counts"]["waiting"]) == (2, 1)
    assert (queue["paused"], queue["leader"]) == (None, None)
    assert queue["oldest_queued"] is not None
    assert queue["blocked_reason"] == not_ready(api)
    assert "no service leads" in queue["blocked_reason"]
    api.term()
    api.engine.reason = "there is no worker today"
    look_again(api)
    queue = api.http.get("/v1/queue").json()
    assert (queue["leader"], queue["blocked_reason"]) == ("tests", not_ready(api)) == ("tests", api.engine.reason)


def look_again(api: Api) -> None:
    """Let the next question whether the service is ready look anew."""
    api.http.app.state.readiness._begin = 0.0  # type: ignore[attr-defined]


def not_ready(api: Api) -> str:
    """The reason why a service is not ready, which is alive."""
    response = api.http.get("/readyz")
    assert response.status_code == 503
    assert response.headers["Content-Type"] == "application/problem+json"
    assert int(response.headers["Retry-After"]) > 0
    assert api.http.get("/livez").status_code == 200
    return response.json()["detail"]


def test_readyz__says_what_was_looked_at(api: Api) -> None:
    api.term()
    ready = api.http.get("/readyz").json()
    assert ready["status"] == "ready"
    assert set(ready["checks"]) == {"store", "data", "disk", "leader", "workers"}


def test_readyz__takes_the_write_lock_once_a_second_and_waits_for_no_store(
    api: Api, monkeypatch: pytest.MonkeyPatch
) -> None:
    pings: list[None] = []
    goes_on = threading.Event()

    def ping() -> None:
        pings.append(None)
        assert goes_on.wait(DEADLINE)

    api.term()
    monkeypatch.setattr(api.store, "ping", ping)
    monkeypatch.setattr(readiness, "REUSE_SECONDS", DEADLINE)
    monkeypatch.setattr(readiness, "TIMEOUT_SECONDS", 0.01)
    try:
        for _ in range(2):
            assert "has not responded" in not_ready(api)
    finally:
        goes_on.set()
    monkeypatch.setattr(readiness, "TIMEOUT_SECONDS", DEADLINE)
    for _ in range(3):
        assert api.http.get("/readyz").status_code == 200
    assert len(pings) == 1
    monkeypatch.setattr(readiness, "REUSE_SECONDS", 0.0)
    assert api.http.get("/readyz").status_code == 200
    assert len(pings) == 2
