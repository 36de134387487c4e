"""A browser logs in with a key, gives orders with the token of a page, and logs out."""

import functools
import re
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pytest

from service.api.browsers import SESSION, TOKEN_HEADER
from service.records.jobs import Scope
from service.store import keys as sessions
from tests.service.support.api import SWEEP, Api, every_route, open_api
from tests.service.support.fakes import issue_key

HTML = {"Accept": "text/html"}


@pytest.fixture
def api(tmp_path: Path) -> Iterator[Api]:
    """A service that asks for a key."""
    issue_key(tmp_path, "nobody")
    with open_api(tmp_path, host="0.0.0.0") as opened:
        opened.http.headers.update(HTML)
        yield opened


def token_on(page: Any) -> str:
    [token] = set(re.findall(r'name="csrf_token" value="(\w+)"', page.text))
    return token


def log_in(api: Api, *scopes: Scope, to: str = "/", name: str = "anna") -> tuple[str, Any]:
    """Log in with a new key; the id of the key and the page that is shown then."""
    key, secret = api.store.keys.issue(name, scopes)
    form = {"key": f" {secret}\n", "to": to, "csrf_token": token_on(api.http.get("/login"))}
    page = api.http.post("/login", data=form)
    assert page.status_code == 200, page.text
    return key.id, page


def test_page__asks_for_the_key_and_is_shown_once_logged_in(api: Api) -> None:
    asked = api.http.get("/sweeps/none")
    assert asked.status_code == 401
    assert 'name="to" value="/sweeps/none"' in asked.text
    wrong = api.http.post("/login", data={"key": "whp_wrong", "to": "/", "csrf_token": token_on(asked)})
    assert wrong.status_code == 401
    assert "this key is unknown" in wrong.text
    assert SESSION not in api.http.cookies
    _, page = log_in(api, Scope.READ)
    assert page.url.path == "/"
    assert "anna" in page.text
    assert api.http.get("/v1/sweeps").status_code == 200


def test_cookies__are_kept_from_scripts_and_other_sites(api: Api) -> None:
    _, secret = api.store.keys.issue("anna", [Scope.READ])
    page = api.http.get("/login")
    login = {"key": secret, "to": "//example.org", "csrf_token": token_on(page)}
    begun = api.http.post("/login", data=login, follow_redirects=False)
    assert (begun.status_code, begun.headers["location"]) == (303, "/")
    for response in (page, begun):
        assert {"HttpOnly", "SameSite=strict", "Path=/"} <= set(response.headers["set-cookie"].split("; "))
    assert secret not in begun.headers["set-cookie"]


def test_order__needs_session_token_and_own_site(api: Api) -> None:
    _, page = log_in(api, Scope.SUBMIT)
    token = token_on(page)
    send: dict[str, Any] = {"json": SWEEP, "headers": {TOKEN_HEADER: token}}
    accepted = api.http.post("/v1/sweeps", **send)
    assert accepted.status_code == 202
    cancel = f"/sweeps/{accepted.json()['id']}/cancel"
    assert api.http.post("/v1/sweeps", json=SWEEP).status_code == 403
    for form in ({}, {"csrf_token": ""}, {"csrf_token": "0" * 64}):
        assert api.http.post(cancel, data=form).status_code == 403
    foreign = {"Origin": "https://example.org", "Sec-Fetch-Site": "cross-site"}
    assert api.http.post(cancel, data={"csrf_token": token}, headers=foreign).status_code == 403
    assert api.http.post(cancel, data={"csrf_token": token}).status_code == 200
    del api.http.cookies[SESSION]
    assert api.http.post(cancel, data={"csrf_token": token}).status_code in (401, 403)
    assert api.http.post("/v1/sweeps", **send).status_code == 401


@pytest.mark.parametrize("how", ["revoked", "expired", "logged out"])
def test_session__ends(api: Api, how: str, monkeypatch: pytest.MonkeyPatch) -> None:
    key, page = log_in(api, Scope.READ)
    secret = api.http.cookies[SESSION]
    if how == "revoked":
        api.store.keys.revoke(key)
    elif how == "expired":
        monkeypatch.setattr(sessions, "now", lambda: datetime.now(UTC) + sessions.SESSION)
    else:
        api.http.post("/logout", data={"csrf_token": token_on(page)})
        assert SESSION not in api.http.cookies
    api.http.cookies[SESSION] = secret
    assert api.http.get("/").status_code == 401


def test_page__offers_what_the_key_may_do(api: Api) -> None:
    _, page = log_in(api, Scope.SUBMIT)
    sent = api.http.post("/v1/sweeps", json=SWEEP, headers={TOKEN_HEADER: token_on(page)})
    page_of_sweep = f"/sweeps/{sent.json()['id']}"

    def offered() -> list[str]:
        return re.findall(rf'action="{page_of_sweep}/(\w+)"', api.http.get(page_of_sweep).text)

    assert offered() == ["cancel", "values"]
    # Anyone who may submit may submit a longer sweep.
    others = {"anna": (Scope.READ, []), "bert": (Scope.SUBMIT, ["values"]), "carl": (Scope.ADMIN, ["cancel", "values"])}
    for name, (scope, may) in others.items():
        log_in(api, scope, name=name)
        assert offered() == may
    cancelled = api.http.post(f"{page_of_sweep}/cancel", data={"csrf_token": token_on(api.http.get(page_of_sweep))})
    assert cancelled.url.path == page_of_sweep
    api.compute()
    assert offered() == ["retry", "delete", "values"]  # it was cancelled
    deleted = api.http.post(f"{page_of_sweep}/delete", data={"csrf_token": token_on(api.http.get(page_of_sweep))})
    assert deleted.url.path == "/"
    assert api.http.get(page_of_sweep).status_code == 404


def test_page__that_is_opened_from_another_site_loads_itself_again_with_its_cookie(api: Api) -> None:
    """The first request carries no cookie, and the response sets none that would replace the one of the log-in."""
    response = api.http.get("/", headers={"Sec-Fetch-Site": "cross-site"})
    assert '<meta http-equiv="refresh" content="0">' in response.text
    assert SESSION not in response.headers.get("set-cookie", "")
    assert 'content="0"' not in api.http.get("/").text


def test_local_browser__needs_no_key_but_the_token(tmp_path: Path) -> None:
    with open_api(tmp_path) as api:
        id = api.submit()
        page = api.http.get(f"/sweeps/{id}")
        run = api.store.sweeps.points(id).items[0].run.id
        for order in (f"/sweeps/{id}/cancel", f"/sweeps/{id}/values", f"/runs/{run}/film", "/new/thin_plate"):
            assert api.http.post(order, data={"axis": "speed", "values": "4 km/s"}).status_code == 403
        cancelled = api.http.post(f"/sweeps/{id}/cancel", data={"csrf_token": token_on(page)}, headers=HTML)
        assert cancelled.status_code == 200
        assert "cancel" in cancelled.text


def test_wrong_keys__of_a_form_are_counted_with_all_others(api: Api) -> None:
    form = {"key": "whp_wrong", "csrf_token": token_on(api.http.get("/login"))}
    assert [api.http.post("/login", data=form).status_code for _ in range(11)] == [401] * 10 + [429]


@pytest.mark.claim("doors", "audit")
def test_every_order_of_a_page__is_recorded(api: Api) -> None:
    """An order of a page leaves a row whether it is carried out or refused, with the key of the log-in."""
    key, page = log_in(api, Scope.ADMIN)
    entries = functools.partial(api.store.audit.entries, datetime.min.replace(tzinfo=UTC))
    token = token_on(page)
    for route in sorted(every_route(), key=lambda route: route.name == "log-out"):  # the last order
        if route.include_in_schema or "POST" not in (route.methods or ()) or route.name == "log-in":
            continue
        path = route.path.replace("{id}", "0" * 32).replace("{order}", "cancel").replace("{scenario}", "thin_plate")
        before = len(entries())
        api.http.post(path, data={"csrf_token": token, "order": "submit"}, follow_redirects=False)
        assert len(entries()) == before + 1, path
    assert {entry.action for entry in entries()} == {"log-in", "submit", "add points", "cancel", "log-out"}
    assert {entry.key_id for entry in entries()} == {key}
