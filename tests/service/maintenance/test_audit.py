"""The audit trail: who gave which order, from where, and what came of it."""

import io
import json
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from types import SimpleNamespace

import pytest
from fastapi.testclient import TestClient

from service import logs
from service.api import access
from service.api.access import MinuteCounter, network_of
from service.api.browsers import SAFE_METHODS
from service.maintenance.audit import READS
from service.records.jobs import AuditEntry, Scope
from service.store.tables import AUDIT
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.api.test_keys import ELSEWHERE, NAME
from tests.service.support.api import SWEEP, Api, every_route, open_api

PEER = "10.1.2.3"


@pytest.fixture
def api(tmp_path: Path) -> Iterator[Api]:
    """A service that asks everyone but a proxy for a key."""
    with open_api(tmp_path, trusted_proxy=["192.0.2.1"], **ELSEWHERE) as opened:
        yield opened


def peer(api: Api, secret: str | None = None, address: str = PEER) -> TestClient:
    """A client at an address, which says that it has another one."""
    headers = {"X-Forwarded-For": "192.0.2.1", "Forwarded": "for=192.0.2.1"}
    headers |= {"Authorization": f"Bearer {secret}"} if secret else {}
    return TestClient(api.http.app, base_url=NAME, headers=headers, client=(address, 50000))


def trail(api: Api) -> tuple[AuditEntry, ...]:
    return api.store.audit.entries(datetime.min.replace(tzinfo=UTC))


@pytest.mark.claim("doors", "audit")
def test_order__has_a_row_with_key_address_action_subject_and_outcome(api: Api, compared: Compared) -> None:
    """Every order has one row: key, owner, address of the peer, action, id, status; what reads has none."""
    key, secret = api.store.keys.issue("anna", [Scope.ADMIN])
    anna = peer(api, secret)
    id = anna.post("/v1/sweeps", json=SWEEP).json()["id"]
    anna.post("/v1/queue/pause")
    anna.patch(f"/v1/sweeps/{id}", json={"priority": 3})
    anna.post(f"/v1/sweeps/{id}/cancel")
    api.compute()
    anna.delete(f"/v1/sweeps/{id}")
    anna.post(f"/v1/sweeps/{id}/retry")
    anna.post("/v1/sweeps", json={})
    orders = [("submit", id, "202"), ("pause", "", "200"), ("prioritise", id, "200"), ("cancel", id, "202")]
    orders += [("delete", id, "204"), ("retry", id, "404"), ("submit", "", "422")]
    got = [(entry.action, entry.subject, entry.outcome) for entry in trail(api)]
    compared(equal("orders in the trail", expected=orders, got=got))
    senders = {(entry.key_id, entry.owner, entry.address) for entry in trail(api)}
    compared(equal("their senders", expected={(key.id, "anna", PEER)}, got=senders))


@pytest.mark.claim("doors", "audit")
def test_every_route_that_changes_something__is_recorded(api: Api, compared: Compared) -> None:
    """A route with an unsafe method leaves a row whether its order is carried out or refused, but for two that read."""
    key, secret = api.store.keys.issue("anna", [Scope.ADMIN])
    anna = peer(api, secret)
    missing = []
    for route in (route for route in every_route() if route.include_in_schema):
        for method in set(route.methods or ()) - SAFE_METHODS:
            before = len(trail(api))
            anna.request(method, route.path.replace("{id}", "0" * 32), json=SWEEP)
            missing += [route.name] * (len(trail(api)) != before + 1)
    compared(equal("routes without a row", expected=sorted(READS), got=sorted(missing)))
    actions = {"submit", "cancel", "pin", "unpin", "retry", "delete", "prioritise", "pause", "resume"}
    compared(equal("actions", expected=actions, got={entry.action for entry in trail(api)}))
    compared(equal("key", expected={key.id}, got={entry.key_id for entry in trail(api)}))


@pytest.mark.claim("doors", "wrong-keys")
def test_wrong_keys__are_slowed_down_by_address(api: Api, compared: Compared) -> None:
    """After ten wrong keys within a minute an address gets 429 with Retry-After for others; a valid key is served."""
    _, secret = api.store.keys.issue("anna", [Scope.READ])
    key, old = api.store.keys.issue("bert", [Scope.READ], datetime.now(UTC) - timedelta(days=1))
    sent = [peer(api, old).get("/v1/sweeps"), *(peer(api, "whp_wrong").get("/v1/sweeps") for _ in range(9))]
    sent += [peer(api, old).post("/v1/queue/pause"), peer(api, "whp_wrong").get("/v1/sweeps")]
    compared(equal("statuses", expected=[401] * 10 + [429] * 2, got=[response.status_code for response in sent]))
    waits = [0 < int(response.headers["Retry-After"]) <= 60 for response in sent[10:]]
    compared(equal("waits of at most a minute", expected=[True] * 2, got=waits))
    others = [peer(api, secret), peer(api, "whp_wrong", "10.1.2.4")]
    got = [other.get("/v1/sweeps").status_code for other in others]
    compared(equal("a valid key, and another address", expected=[200, 401], got=got))
    compared(equal("rows", expected=["refused key"] * 11, got=[entry.action for entry in trail(api)]))
    owners = [(entry.key_id, entry.owner) for entry in trail(api)]
    compared(equal("owners of the keys", expected=[(key.id, "bert")] + [(None, "")] * 10, got=owners))


def test_wrong_keys__are_counted_by_the_minute_and_network_in_bounded_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, counter = SimpleNamespace(monotonic=lambda: 0.0), MinuteCounter()
    monkeypatch.setattr(access, "time", clock)
    assert [counter.count(network_of(f"2001:db8::{host}")) for host in range(11)] == [(n, 60) for n in range(1, 12)]
    for number in range(1, access.MOST_NAMES):
        counter.count(network_of(f"10.0.{number // 256}.{number % 256}"))
    together = [counter.count(network_of(f"192.0.2.{host}")) for host in range(3)]
    assert together == [(1, 60), (2, 60), (3, 60)]
    clock.monotonic = lambda: 60.0
    assert counter.count(network_of("2001:db8::1")) == (1, 60)


@pytest.mark.claim("doors", "audit")
def test_order__is_accepted_though_its_row_cannot_be_written(api: Api, compared: Compared) -> None:
    """An order whose row cannot be written is carried out, answered, and in the log."""
    _, secret = api.store.keys.issue("anna", [Scope.SUBMIT])
    with api.store.database.writing() as connection:
        AUDIT.drop(connection)
    written = io.StringIO()
    logs.configure(written)
    accepted = peer(api, secret).post("/v1/sweeps", json=SWEEP)
    compared(equal("owner of the sweep", expected="anna", got=api.store.sweeps.get(accepted.json()["id"]).owner))
    lines = [json.loads(line) for line in written.getvalue().splitlines()]
    audited = [line for line in lines if line["logger"] == "service.store.events"]
    got = [(line["level"], line["caller"], line["action"], line["address"]) for line in audited]
    compared(equal("lines", expected=[(level, "anna", "submit", PEER) for level in ("info", "error")], got=got))
    assert secret not in written.getvalue()
