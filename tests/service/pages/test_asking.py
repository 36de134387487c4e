"""The form of a new sweep, and the catalogue, by requests; tests/crash has a browser."""

import re
from collections import Counter
from collections.abc import Iterator
from html import unescape
from pathlib import Path
from typing import Any

import pytest

from service.api.browsers import TOKEN_FIELD
from service.pages.forms import OF_DOCUMENT, document_of, fields_of
from service.pages.pages.asking import ORDER, SUBMIT
from service.pages.pages.catalogue import typeset
from service.pages.rendering import ONCE
from service.records.jobs import Scope
from studies import laws, materials, scenarios
from studies.quantities.parameters import declared
from studies.sweeps import examples
from studies.sweeps.document import read_yaml
from studies.sweeps.sweep import Sweep
from tests.service.pages.test_login import log_in, token_on
from tests.service.support.api import SWEEP, Api, open_api
from tests.service.support.fakes import issue_key

FORM = "/new/thin_plate"
FIELDS = {**SWEEP["fixed"], "speed": "3 km/s, 6 km/s", "resolution": "8", "name": "two-speeds"}


@pytest.fixture
def api(tmp_path: Path) -> Iterator[Api]:
    """A service that a browser asks for pages."""
    with open_api(tmp_path) as opened:
        opened.http.headers.update({"Accept": "text/html"})
        yield opened


def send(api: Api, fields: dict[str, str], **more: Any) -> Any:
    """The response to the form of a page, filled in and submitted."""
    token = token_on(api.http.get("/login"))
    return api.http.post(FORM, data={ORDER: SUBMIT, **fields, "csrf_token": token}, **more)


def findings(page: Any) -> dict[str, str]:
    """What the page of a form says at each field."""
    texts = re.findall(r'id="finding-(\w+)">\s*([^<]*?)\s*</p>', page.text)
    return {name: unescape(text) for name, text in texts if text}


def again(document: dict[str, Any]) -> dict[str, Any]:
    """A document that was made the fields of a form, and these a document."""
    return document_of(document["scenario"], fields_of(document))


def runs_of(api: Api, page: Any) -> set[str]:
    id = page.url.path.removeprefix("/sweeps/")
    points = api.http.get(f"/v1/sweeps/{id}/runs", headers={"Accept": "application/json"}).json()
    return {item["run"]["id"] for item in points["items"]}


def test_form__submits_the_sweep_of_its_document(api: Api) -> None:
    sent = send(api, FIELDS)
    assert sent.url.path.startswith("/sweeps/")
    assert "two-speeds" in sent.text
    assert runs_of(api, sent) == {point.run.id for point in Sweep.parse(SWEEP).runs()}


def test_form__that_is_sent_twice_is_one_sweep(api: Api) -> None:
    once = {**FIELDS, ONCE: "a page"}
    paths = [send(api, fields).url.path for fields in (once, once, {**once, "speed": "5 km/s"})]
    assert paths[0] == paths[1] != paths[2]


def test_form__says_at_each_field_what_is_refused_and_keeps_what_was_written(api: Api) -> None:
    refused = send(api, {**FIELDS, "speed": "3 km/s, 6", "plate_thickness": "", "materials": "mine: 5", "title": "<b>"})
    assert refused.status_code == 422
    said = findings(refused)
    assert said.keys() == {"speed", "plate_thickness", "materials"}
    assert "6 km/s" in said["speed"]
    assert 'value="3 km/s, 6"' in refused.text
    assert "<b>" not in refused.text
    assert api.http.get("/v1/sweeps", headers={"Accept": "application/json"}).json()["items"] == []


def test_form__that_is_looked_at_has_cost_and_set_up_and_submits_nothing(api: Api) -> None:
    looked = send(api, {**FIELDS, ORDER: "look"})
    assert looked.status_code == 200
    assert "2 runs" in looked.text
    assert 'alt="The set-up of the first run, to scale' in looked.text
    assert "speed: [3 km/s, 6 km/s]" in looked.text
    missing = send(api, {**FIELDS, "speed": "", ORDER: "look"})
    assert findings(missing) == {}
    assert 'Still needed: <a href="#speed">' in missing.text
    assert api.http.get("/v1/sweeps", headers={"Accept": "application/json"}).json()["items"] == []


def test_form__begins_with_a_preset_a_sweep_or_the_address(api: Api) -> None:
    sent = send(api, FIELDS).url.path.removeprefix("/sweeps/")
    for query, value in (
        ("preset=holes", "{start: 2 km/s, stop: 7 km/s, step: 1 km/s}"),
        (f"sweep={sent}", "3 km/s, 6 km/s"),
        ("speed=4+km/s", "4 km/s"),
    ):
        assert f'id="speed" name="speed" value="{value}"' in api.http.get(f"{FORM}?{query}").text


def check_fields(api: Api, path: str, *of_materials: str) -> None:
    """A page has each id once, and suggests materials where a field takes one."""
    text = api.http.get(path).text
    ids = Counter(re.findall(r'\sid="([^"]*)"', text))
    assert {id for id, count in ids.items() if count > 1} == set(), path
    lists = dict(re.findall(r'<datalist id="([^"]*)">(.*?)</datalist>', text, re.DOTALL))
    asked = dict(re.findall(r'<input [^>]*\bid="([^"]*)"[^>]*\blist="([^"]*)"', text))
    assert {*asked.values()} <= lists.keys(), path
    for field in of_materials:
        assert lists[asked[field]].count("<option") == len(materials.names()), (path, field)


def test_pages__have_each_id_once_and_suggest_materials_where_a_field_takes_one(api: Api) -> None:
    for path in ("/", "/new"):
        check_fields(api, path)
    for name in scenarios.names():
        check_fields(api, f"/new/{name}", *scenarios.load(name).materials)


def test_form__is_offered_to_keys_that_may_submit(tmp_path: Path) -> None:
    issue_key(tmp_path, "nobody")
    with open_api(tmp_path, host="0.0.0.0") as api:
        api.http.headers.update({"Accept": "text/html"})
        for scope, offered in ((Scope.READ, 0), (Scope.SUBMIT, 1)):
            _, page = log_in(api, scope, name=f"key of {scope}")
            assert ('href="/new"' in page.text) == bool(offered)
            assert ("New sweep of this" in api.http.get("/scenarios").text) == bool(offered)
            assert api.http.get(FORM).status_code == (200 if offered else 403)


@pytest.mark.parametrize(
    "document",
    [
        {**SWEEP, "axes": {"plate_thickness": ["2 mm"], "speed": ["3 km/s", "6 km/s"], "target": ["copper-ofhc"]}},
        {"scenario": "deck", "axes": {"deck": ["a deck"], "cells_per_diameter": [8]}},
    ],
)
def test_axis__of_one_value_stays_an_axis_of_the_form(document: dict[str, Any]) -> None:
    fixed = {name: value for name, value in document.get("fixed", {}).items() if name not in document["axes"]}
    assert again({**document, "fixed": fixed})["axes"] == document["axes"]


@pytest.mark.parametrize("name", examples.names())
def test_example__keeps_its_runs_as_fields_of_a_form(name: str) -> None:
    document = read_yaml(examples.text(name), name)
    ours = Sweep.parse(again(document))
    assert {point.run.id for point in ours.every_run(4)} == {
        point.run.id for point in Sweep.parse(document).every_run(4)
    }


def test_form_without_an_axis__has_one_of_its_first_number_or_of_a_default() -> None:
    deck = "\n\n! a deck\n"
    assert document_of("deck", {"deck": deck, "end_time": "2 us"}) == {
        **{"scenario": "deck", "fixed": {"deck": deck}, "axes": {"end_time": ["2 us"]}}
    }
    assert document_of("deck", {"deck": deck})["axes"]


def test_document__without_a_field_for_all_stays_whole() -> None:
    document = {
        **SWEEP,
        "axes": {"speed": {"low": "3 km/s", "high": "6 km/s"}, "target.strength.A": [2e8, 3e8]},
        "combine": "sobol",
        "points": 4,
        "seed": 1,
        "materials": {"mine": {"base": "copper-ofhc", "density": "9 g/cm3"}},
        "observations": [{"speed": "3 km/s", "quantity": "hole_diameter", "value": "9 mm", "source": "me"}],
    }
    assert again(document) == document


def test_fields__of_a_form_are_no_parameters() -> None:
    taken = {ORDER, ONCE, "priority", "keep", TOKEN_FIELD, *OF_DOCUMENT}
    for name in scenarios.names():
        assert not taken & declared(scenarios.load(name).parameters).keys()


def test_law__is_typeset_with_every_number_and_quantity_of_its_equation() -> None:
    for name in laws.names():
        law = laws.load(name)
        bare = unescape(re.sub("<[^>]*>", "", typeset(law.latex)))
        for sign, written in (("−", "-"), ("≤", "<="), ("≥", ">="), ("ρ", "rho"), ("θ", "theta"), ("δ", "delta")):
            bare = bare.replace(sign, written)
        bare = re.sub("[][(){}/_^<·×\\s]", "", bare.replace("ε", "epsilon"))
        plain = re.sub(r"(?<=\d) x(?= \d)|sqrt|[][(){}/_^<\s]", "", law.equation)
        assert bare == plain, name


@pytest.mark.claim("pages", "material-page", minutes=0.1)
def test_material__is_drawn_and_every_constant_has_its_source(api: Api) -> None:
    page = api.http.get("/materials/copper-ofhc")
    assert page.text.count('src="data:image/svg+xml') == 4
    assert "Johnson" in page.text
    assert api.http.get("/materials/coper").status_code == 422


@pytest.mark.parametrize(
    "axes",
    [
        {"plate_thickness": {"low": "2 mm", "high": "4 mm"}, "speed": {"low": "3 km/s", "high": "6 km/s"}},
        {"target.strength.A": {"low": "80 MPa", "high": "100 MPa"}, "speed": {"low": "3 km/s", "high": "6 km/s"}},
    ],
)
def test_sampled_sweep__begins_a_form_with_its_runs_and_follows_the_seed(axes: dict[str, Any]) -> None:
    fixed = {name: value for name, value in SWEEP["fixed"].items() if name not in axes}
    document = {**SWEEP, "fixed": fixed, "axes": axes, "combine": "sobol", "points": 4, "seed": 1}
    stored = Sweep.parse(document).document()
    expected = {point.run.id for point in Sweep.parse(document).runs()}
    fields = fields_of(stored)
    assert {point.run.id for point in Sweep.parse(document_of("thin_plate", fields)).runs()} == expected
    assert (
        not {point.run.id for point in Sweep.parse(document_of("thin_plate", {**fields, "seed": "2"})).runs()}
        & expected
    )


def test_form__keeps_the_ends_of_lines_and_refuses_what_no_field_can_hold(api: Api) -> None:
    shots = "speed [km/s],hole_diameter [mm],source\r\n6,20,me\r\n"
    assert "\r" not in send(api, {**FIELDS, "observations": shots, ORDER: "look"}).text
    for name, text in {"speed": "[3 km/s", "plate_thickness": "# 2 mm", "resolution": "9" * 5000}.items():
        refused = send(api, {**FIELDS, name: text})
        assert refused.status_code == 422
        assert "close each bracket" in findings(refused)[name]
    assert "line 2, column 10" in findings(send(api, {**FIELDS, "materials": "mine:\n  a: [1, }"}))["materials"]
    assert send(api, {**FIELDS, "priority": "-00000001000"}).status_code == 422
    refused = send(api, {**FIELDS, "priority": "abc"})
    assert refused.status_code == 422
    assert 'value="3 km/s, 6 km/s"' in refused.text
    assert "a whole number from" in refused.text


def test_form__leaves_the_cells_of_a_stored_sweep_to_its_accuracy() -> None:
    document: dict[str, Any] = {
        "name": "holes",
        "scenario": "thin_plate",
        "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm"},
        "axes": {"plate_thickness": ["2 mm", "3 mm"]},
        "accuracy": "3 %",
    }
    fields = fields_of({**document, "cells": [20.0, 16.0]})
    assert fields["accuracy"] == "3 %"
    assert document_of("thin_plate", fields) == document
