"""Bad input gets a clear answer and stores nothing; every error is a problem document."""

import gzip
import json
from typing import Any

import pytest

from service.api.dependencies import LONGEST_BODY
from service.records.jobs import StoreUnavailable
from tests.service.support.api import SWEEP, Api, sweep_of

JSON = {"Content-Type": "application/json"}
FIXED: dict[str, Any] = SWEEP["fixed"]


def is_problem(response: Any, status: int) -> bool:
    """Whether a response is a problem document of this status."""
    body = response.json()
    return (
        response.status_code == body["status"] == status
        and response.headers["Content-Type"] == "application/problem+json"
        and body["request_id"] == response.headers["X-Request-ID"]
        and bool(body["title"])
    )


STEP = {"start": "1 km/s", "stop": "9 km/s", "step": "1 mm/s"}


@pytest.mark.claim("bad-input", "bad-input-http")
@pytest.mark.parametrize(
    ("changes", "place", "cure"),
    [
        ({"scenario": "thin_plat"}, "/scenario", "thin_plate"),
        ({"fixed": {**FIXED, "target": "coper-ofhc"}}, "/fixed/target", "copper-ofhc"),
        ({"fixed": {**FIXED, "sped": "6 km/s"}}, "/fixed/sped", "speed"),
        ({"fixed": {**FIXED, "target.strength.AA": "90 MPa"}}, "/fixed/target.strength.AA", "target.strength.A"),
        ({"fixed": {**FIXED, "plate_thickness": "-2 mm"}}, "/fixed/plate_thickness", ""),
        ({"axes": {"speed": ["2 km/s", 6]}}, "/axes/speed/1", "6 km/s"),
        ({"axes": {"speed": []}}, "/axes/speed", ""),
        ({"axes": {"speed": STEP}}, "/axes/speed", ""),
        ({"resolutions": 8}, "/resolutions", "resolution"),
    ],
)
def test_bad_sweep__is_refused_with_field_value_limit_and_cure(
    shared_api: Api, changes: dict[str, Any], place: str, cure: str
) -> None:
    """Bad input over HTTP is a 422 that names field, value, limit and cure, and stores nothing."""
    response = shared_api.http.post("/v1/sweeps", json=sweep_of(**changes))
    assert is_problem(response, 422), response.text
    [error, *_] = [error for error in response.json()["errors"] if error["pointer"] == place]
    assert all(error[name] for name in ("field", "value", "limit", "cure"))
    assert cure in error["cure"]
    assert shared_api.http.get("/v1/sweeps").json()["items"] == []


@pytest.mark.parametrize("path", ["/v1/sweeps", "/v1/sweeps/estimate"])
def test_malformed_json__is_refused_with_line_and_column(shared_api: Api, path: str) -> None:
    response = shared_api.http.post(path, content=b'{"name": "x",\n "axes": }', headers=JSON)
    assert is_problem(response, 422)
    assert response.json()["errors"][0]["value"] == "line 2, column 10"


NUMBERS = ("NaN", "Infinity", "1e999", "-1e999", "1" * 5000)
UNCLEAR = {
    "json": (
        *(json.dumps(SWEEP).replace('"resolution": 8', f'"resolution": {number}').encode() for number in NUMBERS),
        *(b"", b"[]", b'{"name": "a", "name": "b"}', b"[" * 100_000, b"[" * 500 + b"]" * 500),
        *(b'{"name": "\\ud800"}', b'{"\\udfff": 1}', b'{"name": ["a\\u0000b"]}'),
    ),
    "yaml": (
        *(b"", b"null", b"name: \xff", b"name: a\nname: b", b"a: &a [1]\nb: *a", b"[" * 10_000, b"? [a, b]\n: c"),
        *(b"a: !!python/object/apply:os.system [ls]", b"\x00", b'name: "\\ud800"', b'name: "\\0"'),
    ),
}


@pytest.mark.parametrize(("kind", "text"), [(kind, text) for kind, texts in UNCLEAR.items() for text in texts])
def test_document_that_is_unclear__is_refused(shared_api: Api, kind: str, text: bytes) -> None:
    headers = {"Content-Type": f"application/{kind}"}
    assert is_problem(shared_api.http.post("/v1/sweeps", content=text, headers=headers), 422)


def test_body__beyond_the_limit_or_of_another_media_type_is_refused(shared_api: Api) -> None:
    post = shared_api.http.post
    assert is_problem(post("/v1/sweeps", content=b"x" * (LONGEST_BODY + 1), headers=JSON), 413)
    chunks = (b"x" * 1024 * 1024 for _ in range(5))  # without a declared length
    assert is_problem(post("/v1/sweeps", content=chunks, headers=JSON), 413)
    assert is_problem(post("/v1/sweeps", content=json.dumps(SWEEP), headers={"Content-Type": "text/plain"}), 415)


@pytest.mark.parametrize("path", ["/v1/sweeps", "/v1/sweeps/estimate", "/v1/laws/evaluate"])
def test_body__that_is_compressed_is_refused_and_as_it_is_taken(shared_api: Api, path: str) -> None:
    body = json.dumps(SWEEP).encode()
    refused = shared_api.http.post(path, content=gzip.compress(body), headers={**JSON, "Content-Encoding": "gzip"})
    assert is_problem(refused, 415)
    assert refused.headers["Accept-Encoding"] == "identity"
    taken = shared_api.http.post(path, content=body, headers={**JSON, "Content-Encoding": "Identity"})
    assert taken.status_code != 415


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [
        ("GET", "/nowhere", 404),
        ("GET", "/v1/sweeps/nope", 404),
        ("GET", "/v1/sweeps/..%2F..%2Fetc%2Fpasswd", 404),
        ("GET", "/static/..%2Fapp.py", 404),
        ("GET", "/v1/sweeps?limit=0", 422),
        ("GET", "/v1/sweeps?state=nope", 422),
        ("GET", "/v1/sweeps?cursor=nope", 422),
        ("GET", f"/v1/sweeps?cursor={'9' * 40}", 422),
    ],
)
def test_wrong_address__is_a_problem(shared_api: Api, method: str, path: str, status: int) -> None:
    assert is_problem(shared_api.http.request(method, path), status)


def test_unforeseen_error__tells_its_text_to_the_log_only(
    shared_api: Api, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def break_down(*_: Any, **__: Any) -> None:
        raise RuntimeError("secret path /etc/x")

    monkeypatch.setattr(shared_api.store.sweeps, "page", break_down)
    response = shared_api.http.get("/v1/sweeps")
    assert is_problem(response, 500)
    assert "secret" not in response.text
    assert "secret" in caplog.text
    assert response.json()["request_id"] in caplog.text


def test_store_that_is_away__is_a_503_to_be_tried_again(shared_api: Api, monkeypatch: pytest.MonkeyPatch) -> None:
    def be_away(*_: Any, **__: Any) -> None:
        raise StoreUnavailable("the database is locked")

    monkeypatch.setattr(shared_api.store.sweeps, "create", be_away)
    response = shared_api.http.post("/v1/sweeps", json=SWEEP)
    assert is_problem(response, 503)
    assert response.headers["Retry-After"]


@pytest.mark.parametrize(
    ("path", "allow"),
    [
        ("/v1/sweeps", "GET, HEAD, POST"),
        ("/v1/sweeps/{id}", "DELETE, GET, HEAD, PATCH"),
        ("/v1/sweeps/{id}/cancel", "POST"),
    ],
)
def test_wrong_method__lists_every_method_of_the_path(shared_api: Api, path: str, allow: str) -> None:
    response = shared_api.http.put(path.format(id="0" * 32))
    assert is_problem(response, 405)
    assert response.headers["allow"] == allow
