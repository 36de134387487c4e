"""The page of the API: its parts are in the order of work, and each of its examples runs."""

import json
import os
import re
import subprocess
from html import unescape
from pathlib import Path

import pytest

from service.api.errors import PROBLEMS
from service.openapi.routes import TAGS
from service.records.jobs import Scope
from studies.sweeps import examples
from tests.claims.marked import Compared
from tests.claims.rows import equal
from tests.service.support.api import SWEEP, Api, SameFile, served, sweep_of

PARTS = ["submit", "watch", "results", "runs", "catalogue", "keys", "operations"]
EXAMPLE = re.compile(r'<pre class="example">(.*?)</pre>', re.DOTALL)
CURL = "curl --fail --silent --show-error"
ENDLESS, SECONDS = "/v1/queue/events", 1.0  # an example without an end, and how long it is followed
DEADLINE = 30.0  # s, for each of the others
TIMED_OUT = 28  # exit status of curl
ORDERS = ("/cancel", "PATCH")  # of sweeps that have not ended


def test_documentation__has_every_operation_in_one_part_and_every_problem(shared_api: Api) -> None:
    document = shared_api.http.get("/openapi.json").json()
    page = shared_api.http.get("/docs").text
    tags = set()
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            assert f"{method.upper()} {path}" in page
            assert operation["description"], (method, path)
            assert list(operation["responses"]["4XX"]["content"]) == ["application/problem+json"], (method, path)
            [tag] = operation["tags"]
            tags.add(tag)
    assert [tag["name"] for tag in TAGS] == PARTS
    assert tags == {*PARTS} - {"keys"}  # which the operator makes
    places = [page.index(f'<section id="{name}">') for name in PARTS]
    assert places == sorted(places)
    ids = re.findall(r'\bid="([^"]*)"', page)
    assert len(ids) == len(set(ids))
    assert {f"problem-{problem.slug}" for problem in PROBLEMS.values()} <= set(ids)
    body = document["paths"]["/v1/sweeps"]["post"]["requestBody"]["content"]["application/json"]
    assert list(body["examples"]) == examples.names()


@pytest.mark.claim("pages", "api-examples", minutes=0.2)
def test_examples__of_the_documentation_run(api: Api, tmp_path: Path, compared: Compared) -> None:
    """Each example of /docs, run by a shell with curl against a service, succeeds."""
    api.http.app.state.conversions = SameFile(api.settings.data / "cache")  # type: ignore[attr-defined]
    id = api.submit()
    [first, _] = leases = api.store.leases.take(2, api.term())
    for lease in leases:
        log = (api._stored(f"{lease.id}/{name}", b"{}") for name in ("result.json", "state.npz", "film.npz"))
        result = api.result(lease.id)
        api.store.leases.finish(lease, type(result)(**{**vars(result), "files": tuple(log)}))
        file = api.settings.data / "runs" / lease.id[:2] / lease.id / f"a{lease.attempt}-{lease.token}" / "log.txt"
        file.parent.mkdir(parents=True)
        file.write_text("step 1\n")
    api.compute()
    waiting = api.submit(**sweep_of(axes={"speed": ["7 km/s"]}))
    _, secret = api.store.keys.issue("anna", [Scope.READ])
    (tmp_path / "sweep.json").write_text(json.dumps(SWEEP))
    with served(api) as url:
        calls = [unescape(text) for text in EXAMPLE.findall(api.http.get("/docs", headers={"Host": url[7:]}).text)]
        assert len(calls) > 35
        # Orders after questions, and what is deleted last: a pinned sweep is not.
        for example in sorted(calls, key=lambda text: ("-X" in text, "DELETE" in text, not text.endswith("/pin"))):
            sweep = waiting if any(word in example for word in ORDERS) else id
            variables = {**os.environ, "SWEEP": sweep, "RUN": first.id, "WHIPPLE_API_KEY": secret}
            if "DELETE" in example:
                api.compute()  # what the retry asked for
            is_endless = example.endswith(ENDLESS)
            command = f"{CURL} --max-time {SECONDS if is_endless else DEADLINE} {example.removeprefix('curl')}"
            ended = subprocess.run(
                ["bash", "-euc", command], cwd=tmp_path, env=variables, capture_output=True, text=True, check=False
            )
            expected = TIMED_OUT if is_endless else 0
            compared(equal(example.replace(url, ""), expected=expected, got=ended.returncode))
            assert ended.returncode == expected, ended.stderr
    assert {"cube.nc", "archive.zip", "vtk.zip", "film.gif"} < {file.name for file in tmp_path.iterdir()}
