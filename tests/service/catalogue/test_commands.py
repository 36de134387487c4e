"""``whipple list`` and ``whipple schema``."""

import json
from pathlib import Path

import pytest

from service.records.jobs import Scope
from tests.service.support.api import Api, open_api
from tests.service.support.command import run
from tests.service.support.fakes import issue_key

Capsys = pytest.CaptureFixture[str]


@pytest.mark.parametrize(
    ("kind", "name", "words"),
    [
        ("materials", "copper-ofhc", ["8930 kg m-3", "Steinberg (1996)", "strength.A", "90 MPa"]),
        ("laws", "maiden_c", ["2.40 (v/C) (t/d)^(2/3)", "v <= 8 km/s", "verdict"]),
        ("scenarios", "thin_plate", ["from 100 m/s to 20 km/s", "required", "hole_diameter"]),
    ],
)
def test_catalogue__is_that_of_the_api_in_tables_with_units(
    shared_api: Api, capsys: Capsys, kind: str, name: str, words: list[str]
) -> None:
    items = shared_api.http.get(f"/v1/{kind}").json()["items"]
    assert run("list", kind, "--json") == 0
    assert json.loads(capsys.readouterr().out) == items
    assert run("list", kind) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines[1:]] == [item["name"] for item in items]
    assert run("list", kind, name) == 0
    table = capsys.readouterr().out
    assert all(word in table for word in words), table
    assert run("list", kind, f"{name}x") == 2
    assert f"did you mean '{name}'" in capsys.readouterr().err


def test_schema__is_printed_as_it_is_served_also_to_editors_without_a_key(tmp_path: Path, capsys: Capsys) -> None:
    issue_key(tmp_path, "anna", Scope.ADMIN)
    with open_api(tmp_path, host="0.0.0.0", allowed_hosts=("testserver",)) as api:
        response = api.http.get("/v1/schema/sweep")
    assert response.headers["Content-Type"] == "application/schema+json"
    assert run("schema") == 0
    assert json.loads(capsys.readouterr().out) == response.json()
