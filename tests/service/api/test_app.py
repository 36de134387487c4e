"""The app as a whole: what it loads, whom it answers, how it describes itself."""

import subprocess
import sys
from ipaddress import ip_network
from pathlib import Path

import pytest
from fastapi.testclient import TestClient

from service.api.access import check_binding
from service.api.errors import SECURITY_HEADERS
from service.settings import Settings
from studies.quantities.findings import InvalidInput
from tests.service.support.api import SWEEP, Api, open_api

ROOT = Path(__file__).parents[3]
PROXY = (ip_network("10.0.3.0/24"),)
HIT_EVERY_ROUTE = """
import sys
from pathlib import Path
from tests.service.support.api import SWEEP, SameFile, open_api

with open_api(Path(sys.argv[1])) as api:
    api.http.app.state.conversions = SameFile(api.settings.data / "cache")  # children make these files
    id = api.submit()
    api.compute()
    run = api.http.get(f"/v1/sweeps/{id}/runs").json()["items"][0]["run"]["id"]
    paths = set(api.http.app.openapi()["paths"]) | {"/", "/docs", "/sweeps/{id}", "/static/style.css"}
    paths -= {"/v1/queue/events"}  # it does not end
    for path in sorted(paths):
        there = path.replace("{id}", run if "/runs/{id}" in path else id)
        there = there.replace("{name}", "result.json").replace("{format}", "gif")
        for method in ("GET", "POST"):
            answer = api.http.request(method, there, json=SWEEP if method == "POST" else None)
            assert answer.status_code != 500, (method, path, answer.text)
    api.http.delete(f"/v1/sweeps/{id}")
heavy = {"numba", "llvmlite", "xarray", "netCDF4", "matplotlib", "pandas"} & set(sys.modules)
assert not heavy, heavy
print(len(paths), "paths")
"""


def test_api_process__never_loads_solver_or_datasets(tmp_path: Path) -> None:
    answer = subprocess.run(
        [sys.executable, "-c", HIT_EVERY_ROUTE, str(tmp_path)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert answer.returncode == 0, answer.stderr
    assert int(answer.stdout.split()[0]) > 15


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.7", "example.org"])
def test_binding__elsewhere_than_the_loopback_is_refused_with_a_cure(host: str) -> None:
    with pytest.raises(InvalidInput) as refused:
        check_binding(Settings(host=host), has_keys=False)
    [finding] = refused.value.findings
    assert finding.value == host
    assert "127.0.0.1" in finding.cure


def test_binding__behind_a_declared_proxy_needs_the_names_it_is_reached_by(tmp_path: Path) -> None:
    with pytest.raises(InvalidInput, match="whipple keys"), open_api(tmp_path, host="0.0.0.0", trusted_proxy=PROXY):
        pass
    existing = Settings(host="0.0.0.0", trusted_proxy=PROXY, allowed_hosts=("hvi.example.org",))
    check_binding(existing, has_keys=False)


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8000", "127.0.0.1.evil.example", "", "["])
def test_host__of_somebody_else_is_not_answered(shared_api: Api, host: str) -> None:
    response = shared_api.http.get("/v1/sweeps", headers={"Host": host})
    assert response.status_code == 421
    assert response.headers["Content-Type"] == "application/problem+json"


def test_host__that_is_the_address_of_the_service_is_answered(tmp_path: Path) -> None:
    with open_api(tmp_path) as api:
        elsewhere = TestClient(api.http.app, base_url="http://192.0.2.7:8000")
        assert elsewhere.get("/livez").status_code == 200
        assert elsewhere.get("/livez", headers={"Host": "192.0.2.8:8000"}).status_code == 421


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("Host", ["127.0.0.1:8000", "evil.example"]),
        ("Host", ["127.0.0.1:8000", "127.0.0.1:8000"]),
        ("Origin", ["http://127.0.0.1:8000", "https://evil.example"]),
        ("Sec-Fetch-Site", ["none", "cross-site"]),
    ],
)
def test_request__that_says_twice_where_it_comes_from_or_goes_is_refused(
    shared_api: Api, name: str, values: list[str]
) -> None:
    headers = [(name, value) for value in values]
    http = shared_api.http
    for answer in (http.get("/livez", headers=headers), http.post("/v1/sweeps", json=SWEEP, headers=headers)):
        assert answer.status_code == answer.json()["status"] == 400
        assert answer.json()["type"].endswith("bad-request")
        assert name in answer.json()["detail"]
    assert shared_api.http.get("/v1/sweeps").json()["items"] == []


@pytest.mark.parametrize(
    "headers",
    [
        {"Sec-Fetch-Site": "cross-site"},
        {"Sec-Fetch-Site": "same-site"},
        {"Origin": "https://evil.example"},
        {"Origin": "http://127.0.0.1:3000"},
        {"Origin": "null"},
        {"Origin": "http://["},
        {"Origin": ""},
    ],
)
def test_write__from_another_site_is_refused_and_stores_nothing(shared_api: Api, headers: dict[str, str]) -> None:
    response = shared_api.http.post("/v1/sweeps", json=SWEEP, headers=headers)
    assert response.status_code == 403
    assert shared_api.http.get("/v1/sweeps").json()["items"] == []


@pytest.mark.parametrize("path", ["/", "/livez", "/nowhere", "/static/style.css", "/v1/sweeps", "/v1/queue"])
def test_every_answer__says_what_a_browser_may_not_do_with_it(
    shared_api: Api, path: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr("service.store.queue.Queue.status")
    response = shared_api.http.get(path)
    assert (response.status_code == 500) == (path == "/v1/queue")
    headers = response.headers
    assert {name: headers[name] for name in SECURITY_HEADERS} == SECURITY_HEADERS
    assert "frame-ancestors 'none'" in headers["Content-Security-Policy"]
    assert "server" not in headers
