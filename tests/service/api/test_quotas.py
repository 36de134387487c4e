"""What a key may have: sweeps, runs, bytes, requests a minute, priorities, kept files; and what the machine has."""

from pathlib import Path
from typing import Any

import httpx
import pytest

from service.client.client import Client
from service.records.jobs import Keep, Scope
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support.api import SWEEP, Api, open_api, served, sweep_of

FREE = (1 << 30) + 100_000  # bytes, of which the reserve leaves little
OTHER = sweep_of(axes={"speed": ["4 km/s", "5 km/s"]})


def header_of(api: Api, scope: Scope = Scope.SUBMIT) -> dict[str, str]:
    return {"Authorization": f"Bearer {api.store.keys.issue('anna', [scope])[1]}"}


@pytest.mark.claim("doors", "quotas")
@pytest.mark.parametrize(
    ("quota", "numbers", "wait"),
    [
        ({"quota_sweeps": 1}, "anna has 1 sweeps under way, and the quota is 1", 60),
        ({"quota_runs": 3}, "anna has 2 runs under way and asks for 2; the quota is 3", 60),
        ({"quota_bytes": 347_203}, "of files and asks for 0.000347 GB; the quota is 0.000347 GB", 3600),
    ],
    ids=["sweeps", "runs", "bytes"],
)
def test_quota__is_met_by_a_client_that_waits_as_told_and_ends(
    quota: dict[str, int], numbers: str, wait: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compared: Compared
) -> None:
    """A sweep beyond a quota gets 429 with both numbers and Retry-After; a client that waits so long is served."""
    waited: list[float] = []
    with open_api(tmp_path, **quota) as api, served(api) as url:
        key = header_of(api)
        first = httpx.post(f"{url}/v1/sweeps", json=SWEEP, headers=key).json()["id"]
        if "quota_bytes" in quota:
            api.compute()
        refused = httpx.post(f"{url}/v1/sweeps", json=OTHER, headers=key)
        compared(equal("status and Retry-After", expected=(429, str(wait)), got=_refusal(refused)))
        assert numbers in refused.json()["detail"]

        def sleep(seconds: float) -> None:
            waited.append(seconds)
            api.compute()
            if "quota_bytes" in quota:
                api.store.sweeps.delete(first)

        monkeypatch.setattr("service.client.connection.time.sleep", sleep)
        with Client(url, key=key["Authorization"].removeprefix("Bearer "), patience=4000.0) as client:
            client.submit(OTHER)
    compared(equal("seconds that the client waited", expected=[wait], got=waited))


def _refusal(response: Any) -> tuple[int, str]:
    return response.status_code, response.headers["retry-after"]


@pytest.mark.claim("doors", "request-rate")
def test_requests__of_a_key_beyond_its_quota_are_told_how_long_to_wait(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, compared: Compared
) -> None:
    """Responses count down in RateLimit fields; requests beyond the quota get 429 until the minute is over."""
    moment = 100.0
    monkeypatch.setattr("service.api.access.time.monotonic", lambda: moment)
    with open_api(tmp_path, quota_requests=2) as api:
        key = header_of(api)
        first, second, third = (api.http.get("/v1/sweeps", headers=key) for _ in range(3))
        assert first.headers["ratelimit-policy"] == '"requests";q=2;w=60'
        compared(equal("RateLimit of the first", expected='"requests";r=1;t=60', got=first.headers["ratelimit"]))
        compared(equal("RateLimit of the second", expected='"requests";r=0;t=60', got=second.headers["ratelimit"]))
        moment += 50.5
        compared(equal("status and Retry-After of the third", expected=(429, "60"), got=_refusal(third)))
        fourth = api.http.get("/v1/sweeps", headers=key)
        compared(equal("status and Retry-After later", expected=(429, "10"), got=_refusal(fourth)))
        moment += 10.0
        assert api.http.get("/v1/sweeps", headers=key).status_code == 200
        order = api.http.post(f"/v1/sweeps/{'0' * 32}/cancel", headers=key)
        told = order.status_code, order.headers["ratelimit"]
        compared(equal("an order after it counts once", expected=(404, '"requests";r=0;t=60'), got=told))
        free = api.http.get("/v1/sweeps")  # a user of this machine
        assert "ratelimit" not in free.headers


@pytest.mark.claim("doors", "at-the-door")
@pytest.mark.parametrize(
    ("settings", "query", "field", "numbers"),
    [
        ({"memory_limit": "100MiB"}, {}, "memory", ("296.6 MiB", "100.0 MiB")),
        ({"disk_reserve": "1GiB"}, {}, "disk", ("0.3 MiB", "0.1 MiB")),
        ({"quota_runs": 1}, {}, "document", ("2 runs", "at most 1 runs")),
        ({"quota_bytes": 1000}, {}, "document", ("0.3 MiB", "0.0 MiB")),
        ({}, {"priority": -1}, "priority", ("-1", "from 0 to 100")),
        ({"most_kept": Keep.FINAL}, {"keep": "film"}, "keep", ("film", "final")),
    ],
)
def test_submission__that_can_never_be_computed_is_refused_with_both_numbers(
    settings: dict[str, Any],
    query: dict[str, Any],
    field: str,
    numbers: tuple[str, str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    compared: Compared,
) -> None:
    """Estimates beyond memory, disk or quota are refused at the door, priority and files by the scope of the key."""
    monkeypatch.setattr("service.api.dependencies.free_bytes", lambda _folder: FREE if field == "disk" else 2 * FREE)
    with open_api(tmp_path, **settings) as api:
        response = api.http.post("/v1/sweeps", json=SWEEP, params=query, headers=header_of(api))
        [error] = response.json()["errors"]
        compared(equal("status and field", expected=(422, field), got=(response.status_code, error["field"])))
        asked, allowed = numbers
        assert asked in error["value"], error
        assert allowed in error["limit"], error
        compared(equal("sweeps stored", expected=0, got=len(api.store.sweeps.page().items)))
        if field in ("priority", "keep", "document"):
            admin = header_of(api, Scope.ADMIN)
            assert api.http.post("/v1/sweeps", json=SWEEP, params=query, headers=admin).status_code == 202


@pytest.mark.claim("doors", "at-the-door")
def test_change__to_a_priority_that_passes_others_needs_the_scope_admin(tmp_path: Path, compared: Compared) -> None:
    """A key without ``admin`` gives its own sweep no priority that it could not have submitted it with."""
    with open_api(tmp_path) as api:
        own, admin = header_of(api), header_of(api, Scope.ADMIN)
        sweep = api.http.post("/v1/sweeps", json=SWEEP, headers=own).json()["links"]["self"]
        changes = [(own, 5), (own, -1), (admin, -1)]
        got = [api.http.patch(sweep, json={"priority": to}, headers=key).status_code for key, to in changes]
        compared(equal("status of 5 and -1 without, and -1 with admin", expected=[200, 422, 200], got=got))
