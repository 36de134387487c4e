"""API keys over HTTP: who is let in, what each scope allows, whose sweep is whose."""

import io
import logging
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi.testclient import TestClient

from service import logs
from service.records.jobs import Scope
from tests.service.support.api import SWEEP, Api, open_api, served
from tests.service.support.fakes import issue_key

ELSEWHERE = {"host": "0.0.0.0", "allowed_hosts": ("whipple.example.org",)}
NAME = "http://whipple.example.org"
WITHOUT_KEY = {"/livez", "/readyz", "/version", "/v1/schema/sweep"}  # asked by machines and editors that have none


def key_for(api: Api, *scopes: Scope, name: str = "anna", **more: Any) -> dict[str, str]:
    _, secret = api.store.keys.issue(name, scopes, **more)
    return {"Authorization": f"Bearer {secret}"}


@pytest.fixture
def api(tmp_path: Path) -> Iterator[Api]:
    """A service that can be reached from elsewhere; the key which lets it start is nobody's."""
    issue_key(tmp_path, "nobody")
    with open_api(tmp_path, **ELSEWHERE) as opened:
        yield opened


def is_refused(response: Any, status: int, challenge: str) -> bool:
    """Whether an answer is a problem document with a challenge (RFC 6750)."""
    return (
        response.status_code == response.json()["status"] == status
        and response.headers["Content-Type"] == "application/problem+json"
        and response.headers["WWW-Authenticate"].startswith('Bearer realm="whipple"')
        and challenge in response.headers["WWW-Authenticate"]
    )


def test_every_operation__needs_a_key_elsewhere(api: Api) -> None:
    for path, methods in api.http.app.openapi()["paths"].items():  # type: ignore[attr-defined]
        for method in methods:
            response = api.http.request(method.upper(), path.replace("{id}", "0" * 32))
            if path in WITHOUT_KEY:
                assert response.status_code in (200, 503), path
            else:
                assert is_refused(response, 401, ""), (method, path, response.text)
    assert api.http.get("/metrics").status_code == 401


def test_request__by_another_name_than_the_loopbacks_needs_a_key(tmp_path: Path) -> None:
    with open_api(tmp_path, allowed_hosts=("whipple.example.org",)) as api:
        proxied = TestClient(api.http.app, base_url=NAME)
        assert proxied.get("/v1/sweeps").status_code == 401
        assert api.http.get("/v1/sweeps").status_code == 200
        assert proxied.get("/v1/sweeps", headers=key_for(api, Scope.READ)).status_code == 200


def test_request__by_way_of_a_declared_proxy_needs_none_and_one_around_it_does(tmp_path: Path) -> None:
    forwarded = {"X-Forwarded-For": "10.0.4.1", "Forwarded": "for=10.0.4.1"}
    with open_api(tmp_path, trusted_proxy=["10.0.3.0/24", "10.0.4.1"], **ELSEWHERE) as api:
        for peer in ("10.0.3.7", "10.0.4.1", "::ffff:10.0.4.1"):
            proxied = TestClient(api.http.app, base_url=NAME, client=(peer, 50000))
            assert proxied.post("/v1/sweeps", json=SWEEP).status_code == 202
        for peer in ("10.0.4.2", "::1", "testclient"):
            around = TestClient(api.http.app, base_url=NAME, client=(peer, 50000))
            assert is_refused(around.get("/v1/sweeps", headers=forwarded), 401, "")
            assert around.get("/v1/sweeps", headers=key_for(api, Scope.READ)).status_code == 200


def test_key__that_is_unknown_is_refused_everywhere(api: Api, shared_api: Api) -> None:
    for header in ("Bearer whp_wrong", "Bearer " + "x" * 5000, "Bearer", "Bearer ", "Basic YTpi", "", "bearer é"):
        headers = {b"Authorization": header.encode("latin-1")}
        for each in (api, shared_api):  # the other one listens on the loopback
            assert is_refused(each.http.get("/v1/sweeps", headers=headers), 401, "invalid_token"), header


def test_key__that_is_revoked_or_past_its_time_is_refused(api: Api) -> None:
    row, secret = api.store.keys.issue("bert", [Scope.READ])
    key = {"Authorization": f"Bearer {secret}"}
    assert api.http.get("/v1/sweeps", headers=key).status_code == 200
    api.store.keys.revoke(row.id)
    assert is_refused(api.http.get("/v1/sweeps", headers=key), 401, "invalid_token")
    old = key_for(api, Scope.READ, expires=datetime.now(UTC) - timedelta(seconds=1))
    assert is_refused(api.http.get("/v1/sweeps", headers=old), 401, "invalid_token")


ALLOWED = {
    Scope.READ: {("GET", "/v1/sweeps"), ("GET", "/v1/queue"), ("GET", "/metrics")},
    Scope.SUBMIT: {("POST", "/v1/sweeps"), ("POST", "/v1/sweeps/estimate")},
    Scope.ADMIN: {("POST", "/v1/queue/pause"), ("POST", "/v1/queue/resume")},
}


@pytest.mark.parametrize("scope", Scope)
def test_scope__allows_what_it_says_and_no_more(api: Api, scope: Scope) -> None:
    key = key_for(api, scope)
    order = list(ALLOWED)
    for place, needed in enumerate(order):
        for method, path in ALLOWED[needed]:
            body = SWEEP if "sweeps" in path and method == "POST" else None
            response = api.http.request(method, path, json=body, headers=key)
            if place <= order.index(scope) or path.endswith("estimate"):
                assert response.is_success, (path, response.text)
            else:
                assert is_refused(response, 403, f'scope="{needed}"'), (path, response.text)


ORDERS = (
    *(("POST", "/cancel", None), ("POST", "/retry", None), ("PATCH", "", {"priority": 3})),
    *(("PUT", "/pin", None), ("DELETE", "/pin", None), ("DELETE", "", None)),
)


def submitted(api: Api, key: dict[str, str]) -> dict[str, Any]:
    return api.http.post("/v1/sweeps", json=SWEEP, headers=key).json()


@pytest.mark.parametrize(("method", "path", "body"), ORDERS)
def test_order__is_taken_from_the_owner_and_from_admin_alone(api: Api, method: str, path: str, body: Any) -> None:
    anna = key_for(api, Scope.SUBMIT, name="anna")
    bert = key_for(api, Scope.SUBMIT, name="bert")
    carl = key_for(api, Scope.ADMIN, name="carl")
    sweep = submitted(api, anna)
    assert sweep["owner"] == "anna"
    there = f"/v1/sweeps/{sweep['id']}{path}"
    refused = api.http.request(method, there, json=body, headers=bert)
    assert is_refused(refused, 403, 'scope="admin"')
    assert "owner" in refused.json()["detail"]
    for key in (anna, carl):
        answer = api.http.request(method, there, json=body, headers=key)
        assert answer.is_success or answer.status_code in (404, 409), answer.text


def test_idempotency_key__is_its_owners(api: Api) -> None:
    keys = [key_for(api, Scope.SUBMIT, name=name) | {"Idempotency-Key": "same"} for name in ("anna", "bert")]
    assert len({submitted(api, key)["id"] for key in keys}) == 2


def test_key__on_the_loopback_owns_what_is_submitted_with_it(tmp_path: Path) -> None:
    with open_api(tmp_path) as api:
        sweep = submitted(api, key_for(api, Scope.SUBMIT))
        assert sweep["owner"] == "anna"
        assert submitted(api, {})["owner"] == ""
        reader = key_for(api, Scope.READ, name="bert")
        assert api.http.post("/v1/sweeps", json=SWEEP, headers=reader).status_code == 403
        assert api.http.post(f"/v1/sweeps/{sweep['id']}/cancel").status_code == 202


def test_secret__is_neither_logged_nor_answered(api: Api) -> None:
    _, secret = api.store.keys.issue("anna", [Scope.READ])
    written = io.StringIO()
    logs.configure(written)
    logging.getLogger(logs.OURS).setLevel(logging.DEBUG)
    with served(api) as url:
        host = {"Host": "whipple.example.org"}
        answers = [
            httpx.get(f"{url}{path}", headers={**host, "Authorization": f"Bearer {value}"})
            for path in ("/v1/sweeps", "/v1/sweeps/nope", f"/v1/sweeps?cursor={'x' * 9}")
            for value in (secret, secret[:-1], secret.upper())
        ]
    assert written.getvalue().count("\n") >= len(answers)
    assert "anna" in written.getvalue()
    for text in (written.getvalue(), *(answer.text + str(answer.headers) for answer in answers)):
        assert secret[4:] not in text
        assert secret[4:-1] not in text
