"""Bad input gets a clear answer and stores nothing; every error is a problem document."""

import json
import logging
import socket
from collections.abc import Iterator
from typing import Any
from urllib.parse import urlsplit

import pytest

from service.api.documents import pointer
from service.api.routes.dependencies import LONGEST_BODY
from tests.service.support.api import SWEEP, Api, open_api, served, sweep_of, until

JSON = {"Content-Type": "application/json"}
YAML = {"Content-Type": "application/yaml"}
FIXED: dict[str, Any] = SWEEP["fixed"]


@pytest.fixture(scope="module")
def api(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Api]:
    with open_api(tmp_path_factory.mktemp("errors")) as opened:
        yield opened


def is_problem(response: Any, status: int) -> bool:
    """Whether an answer is a problem document of this status."""
    body = response.json()
    return (
        response.status_code == body["status"] == status
        and response.headers["Content-Type"] == "application/problem+json"
        and body["request_id"] == response.headers["X-Request-ID"]
        and bool(body["title"])
    )


BAD: dict[str, tuple[dict[str, Any], str, str]] = {
    "unknown scenario": ({"scenario": "thin_plat"}, "/scenario", "thin_plate"),
    "unknown material": ({"fixed": {**FIXED, "target": "coper-ofhc"}}, "/fixed/target", "copper-ofhc"),
    "unknown parameter": ({"fixed": {**FIXED, "sped": "6 km/s"}}, "/fixed/sped", "speed"),
    "unknown constant": (
        {"fixed": {**FIXED, "target.strength.AA": "90 MPa"}},
        "/fixed/target.strength.AA",
        "target.strength.A",
    ),
    "bare number": ({"axes": {"speed": ["2 km/s", 6]}}, "/axes/speed/1", "6 km/s"),
    "wrong unit": ({"axes": {"speed": ["2 km"]}}, "/axes/speed/0", ""),
    "negative": ({"fixed": {**FIXED, "plate_thickness": "-2 mm"}}, "/fixed/plate_thickness", ""),
    "empty axis": ({"axes": {"speed": []}}, "/axes/speed", ""),
    "unknown key": ({"resolutions": 8}, "/resolutions", "resolution"),
    "too many values": (
        {"axes": {"speed": {"start": "1 km/s", "stop": "9 km/s", "step": "1 mm/s"}}},
        "/axes/speed",
        "",
    ),
    "too many runs": (
        {
            "axes": {
                "speed": {"start": "1 km/s", "stop": "9 km/s", "step": "10 m/s"},
                "projectile_diameter": {"start": "1 mm", "stop": "9 mm", "step": "10 um"},
            },
            "fixed": {k: v for k, v in FIXED.items() if k != "projectile_diameter"},
        },
        "/axes",
        "",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_sweep__is_refused_with_field_value_limit_and_cure(api: Api, case: str) -> None:
    changes, place, cure = BAD[case]
    response = api.http.post("/v1/sweeps", json=sweep_of(**changes))
    assert is_problem(response, 422), response.text
    result = [error for error in response.json()["errors"] if error["pointer"] == place]
    assert result, response.json()["errors"]
    assert all(result[0][word] for word in ("field", "value", "limit", "cure"))
    assert cure in result[0]["cure"]
    assert api.http.get("/v1/sweeps").json()["items"] == []


@pytest.mark.parametrize("number", ["NaN", "Infinity", "1e999", "-1e999", "1" * 5000])
def test_number_that_is_none__is_refused(api: Api, number: str) -> None:
    text = json.dumps(SWEEP).replace('"resolution": 8', f'"resolution": {number}')
    assert is_problem(api.http.post("/v1/sweeps", content=text, headers=JSON), 422)


@pytest.mark.parametrize("path", ["/v1/sweeps", "/v1/sweeps/estimate"])
def test_malformed_json__is_refused_with_line_and_column(api: Api, path: str) -> None:
    response = api.http.post(path, content=b'{"name": "x",\n "axes": }', headers=JSON)
    assert is_problem(response, 422)
    assert response.json()["errors"][0]["value"] == "line 2, column 10"


@pytest.mark.parametrize(
    ("text", "headers"),
    [
        (b"", JSON),
        (b"", YAML),
        (b"[]", JSON),
        (b"null", YAML),
        (b"name: \xff", YAML),
        (b'{"name": "a", "name": "b"}', JSON),
        (b"name: a\nname: b", YAML),
        (b"a: &a [1]\nb: *a", YAML),
        (b"a: !!python/object/apply:os.system [ls]", YAML),
        (b"[" * 100_000, JSON),
        (b"[" * 10_000, YAML),
        (b"[" * 500 + b"]" * 500, JSON),
        (b"? [a, b]\n: c", YAML),
        (b"\x00", YAML),
        (b'{"name": "\\ud800"}', JSON),
        (b'{"\\udfff": 1}', JSON),
        (b'{"name": ["a\\u0000b"]}', JSON),
        (b'name: "\\ud800"', YAML),
        (b'name: "\\0"', YAML),
    ],
)
def test_document_that_says_nothing_clear__is_refused(api: Api, text: bytes, headers: dict[str, str]) -> None:
    assert is_problem(api.http.post("/v1/sweeps", content=text, headers=headers), 422)


def test_body_over_the_limit__is_a_413(api: Api) -> None:
    response = api.http.post("/v1/sweeps", content=b"x" * (LONGEST_BODY + 1), headers=JSON)
    assert is_problem(response, 413)


def test_body_over_the_limit__is_a_413_without_a_declared_length_too(api: Api) -> None:
    chunks = (b"x" * 1024 * 1024 for _ in range(5))
    assert is_problem(api.http.post("/v1/sweeps", content=chunks, headers=JSON), 413)


def test_other_media_type__is_a_415(api: Api) -> None:
    headers = {"Content-Type": "text/plain"}
    response = api.http.post("/v1/sweeps", content=json.dumps(SWEEP), headers=headers)
    assert is_problem(response, 415)


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [
        ("GET", "/nowhere", 404),
        ("GET", "/v1/sweeps/nope", 404),
        ("GET", "/v1/sweeps/nope/runs", 404),
        ("GET", "/v1/sweeps/nope/cube.nc", 404),
        ("POST", "/v1/sweeps/nope/cancel", 404),
        ("POST", "/v1/sweeps/nope/retry", 404),
        ("DELETE", "/v1/sweeps/nope", 404),
        ("GET", "/v1/runs/nope", 404),
        ("GET", "/v1/sweeps/..%2F..%2Fetc%2Fpasswd", 404),
        ("GET", "/static/..%2Fapp.py", 404),
        ("PUT", "/v1/sweeps", 405),
        ("GET", "/v1/sweeps?limit=0", 422),
        ("GET", "/v1/sweeps?state=nope", 422),
        ("GET", "/v1/sweeps?cursor=nope", 422),
        ("GET", f"/v1/sweeps?cursor={'9' * 40}", 422),
        ("GET", "/?cursor=-1", 422),
    ],
)
def test_wrong_address__is_a_problem(api: Api, method: str, path: str, status: int) -> None:
    assert is_problem(api.http.request(method, path), status)


def test_unforeseen_error__tells_its_text_to_the_log_only(
    api: Api, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def break_down(*_: Any, **__: Any) -> None:
        raise RuntimeError("secret path /etc/x")

    monkeypatch.setattr(type(api.store), "sweeps", break_down)
    response = api.http.get("/v1/sweeps")
    assert is_problem(response, 500)
    assert "secret" not in response.text
    assert "secret" in caplog.text
    assert response.json()["request_id"] in caplog.text


def test_store_that_is_away__is_a_503_to_be_tried_again(api: Api, monkeypatch: pytest.MonkeyPatch) -> None:
    from service.records.jobs import StoreUnavailable

    def be_away(*_: Any, **__: Any) -> None:
        raise StoreUnavailable("the database is locked")

    monkeypatch.setattr(type(api.store), "create_sweep", be_away)
    response = api.http.post("/v1/sweeps", json=SWEEP)
    assert is_problem(response, 503)
    assert response.headers["Retry-After"]


def test_pointer__stops_where_the_document_ends() -> None:
    document = {"axes": {"speed": [1], "a/b~": 2}}
    assert pointer("axes.speed[7]", document) == "/axes/speed"
    assert pointer("axes.a/b~", document) == "/axes/a~1b~0"
    assert pointer("nothing", document) == ""
    assert pointer("axes", None) == ""


def test_body__that_ends_with_its_connection_is_no_failure_of_the_service(
    api: Api, caplog: pytest.LogCaptureFixture
) -> None:
    head = b"POST /v1/sweeps HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
    with caplog.at_level(logging.INFO), served(api) as url:
        place = urlsplit(url)
        with socket.create_connection((place.hostname, place.port)) as connection:
            connection.sendall(head + b'Content-Length: 1000\r\n\r\n{"name":')
        until(lambda: any("POST /v1/sweeps" in line for line in caplog.messages), seconds=20)
    assert [line for line in caplog.messages if "POST" in line] == ["POST /v1/sweeps 400"]
    assert all(line.levelno < logging.WARNING and not line.exc_info for line in caplog.records)


@pytest.mark.parametrize(
    ("path", "allow"),
    [("/v1/sweeps", "GET, POST"), ("/v1/sweeps/{id}", "DELETE, GET, PATCH"), ("/v1/sweeps/{id}/cube.nc", "GET, HEAD")],
)
def test_wrong_method__lists_every_method_of_the_path(api: Api, path: str, allow: str) -> None:
    response = api.http.put(path.format(id="0" * 32))
    assert (response.status_code, response.headers["allow"]) == (405, allow)


def test_browser__gets_a_page_and_a_program_the_document(api: Api) -> None:
    path = f"/sweeps/{'0' * 32}"
    page = api.http.get(path, headers={"Accept": "text/html,application/xhtml+xml,*/*;q=0.8"})
    assert (page.status_code, page.headers["content-type"]) == (404, "text/html; charset=utf-8")
    assert "<h1>Not found</h1>" in page.text
    assert "style-src 'self'" in page.headers["content-security-policy"]
    document = api.http.get(path)
    assert document.headers["content-type"] == "application/problem+json"
    assert page.headers["vary"] == document.headers["vary"] == "Accept"
