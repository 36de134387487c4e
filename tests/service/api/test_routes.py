"""The interface, endpoint by endpoint, on a real store."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from studies import examples
from studies.values.recipes import ACCURACY
from tests.service.support.api import FILES, SWEEP, Api, open_api


@pytest.fixture
def api(tmp_path: Path) -> Iterator[Api]:
    with open_api(tmp_path) as opened:
        yield opened


# --- submit -----------------------------------------------------------------------------------------


def test_submit__answers_202_with_location_and_retry_after(api: Api) -> None:
    response = api.http.post("/v1/sweeps", json=SWEEP)
    assert response.status_code == 202
    assert response.headers["Location"] == response.json()["links"]["self"]
    assert int(response.headers["Retry-After"]) > 0


def test_submit__says_planned_reused_and_new(api: Api) -> None:
    api.submit()
    again = api.http.post("/v1/sweeps", json={**SWEEP, "axes": {"speed": ["6 km/s", "7 km/s"]}})
    assert [again.json()[word] for word in ("planned", "reused", "new")] == [2, 1, 1]


def test_submit__has_committed_the_row_before_it_answers(api: Api, tmp_path: Path) -> None:
    from service.store import Store

    id = api.submit()
    other = Store.open(api.settings.url)
    assert other.sweep(id).planned == 2
    other.close()


@pytest.mark.parametrize("name", examples.names())
def test_submit__takes_each_example_as_yaml(api: Api, name: str) -> None:
    headers = {"Content-Type": "application/yaml"}
    response = api.http.post("/v1/sweeps", content=examples.text(name), headers=headers)
    assert response.status_code == 202, response.text
    assert response.json()["name"] == name


def test_document__of_a_sweep_can_be_submitted_again(api: Api) -> None:
    document = api.http.get(f"/v1/sweeps/{api.submit()}/document").json()
    assert api.http.post("/v1/sweeps", json=document).json()["reused"] == 2


# --- look -------------------------------------------------------------------------------------------


def test_sweep__shows_counts_progress_and_links(api: Api) -> None:
    sweep = api.http.get(f"/v1/sweeps/{api.submit()}").json()
    assert sweep["state"] == "queued"
    assert sweep["counts"]["queued"] == 2
    assert sweep["progress"] == 0
    assert "cancel" in sweep["links"]
    assert not {"retry", *FILES} & set(sweep["links"])
    for name in ("self", "runs", "document", "history"):
        assert api.http.get(sweep["links"][name]).status_code == 200


def test_sweep__that_succeeded_links_its_files(api: Api) -> None:
    id = api.submit()
    api.compute()
    sweep = api.http.get(f"/v1/sweeps/{id}").json()
    assert sweep["state"] == "succeeded"
    assert set(FILES) <= set(sweep["links"])
    for name in FILES:
        assert api.http.get(sweep["links"][name]).content == FILES[name]


def test_list__names_the_next_page_in_a_link(api: Api) -> None:
    ids = [api.submit(name=f"sweep-{number}") for number in range(5)]
    received: list[str] = []
    there: str | None = "/v1/sweeps?limit=2&state=queued"
    while there is not None:
        answer = api.http.get(there)
        received += [sweep["id"] for sweep in answer.json()["items"]]
        there = answer.links.get("next", {}).get("url")
    assert received == ids[::-1]


def test_runs__can_be_asked_by_state(api: Api) -> None:
    id = api.submit()
    api.compute(failures=1)
    failed = api.http.get(f"/v1/sweeps/{id}/runs?state=failed").json()["items"]
    assert [point["coordinates"] for point in failed] == [{"speed": 3000.0}]
    assert "particle 17" in failed[0]["run"]["reason"]


def test_run__shows_its_whole_question_and_its_measurements(api: Api) -> None:
    id = api.submit()
    api.compute()
    point = api.http.get(f"/v1/sweeps/{id}/runs").json()["items"][0]
    run = api.http.get(point["run"]["links"]["self"]).json()
    assert run["question"]["parameters"]["projectile_diameter"] == 0.008
    assert run["summary"]["measurements"]["hole_diameter"]["value"] == 0.0148
    assert "path" not in run


# --- order ------------------------------------------------------------------------------------------


def test_delete__is_refused_while_a_sweep_runs(api: Api) -> None:
    id = api.submit()
    response = api.http.delete(f"/v1/sweeps/{id}")
    assert response.status_code == 409
    assert "cancel" in response.json()["detail"]
    assert api.http.get(f"/v1/sweeps/{id}").status_code == 200


def test_estimate__counts_and_stores_nothing(api: Api) -> None:
    api.submit()
    more = {**SWEEP, "axes": {"speed": ["6 km/s", "7 km/s"]}}
    answer = api.http.post("/v1/sweeps/estimate", json=more).json()
    assert (answer["runs"], answer["reused"]) == (2, 1)
    assert answer["core_seconds"] > 0
    assert answer["bytes"] > 0
    assert len(api.http.get("/v1/sweeps").json()["items"]) == 1


@pytest.mark.parametrize("model_part", ["stored", "screen"])
def test_estimate__shows_what_each_accuracy_would_cost(api: Api, model_part: str) -> None:
    sweep = {**SWEEP, "model_part": model_part}
    presets = api.http.post("/v1/sweeps/estimate", json=sweep).json()["presets"]
    assert [preset["name"] for preset in presets] == list(ACCURACY)
    for preset in presets:
        at = {key: value for key, value in sweep.items() if key != "resolution"}
        asked = api.http.post("/v1/sweeps/estimate", json=at | {"accuracy": preset["name"]}).json()
        for word in ("runs", "core_seconds", "bytes"):
            assert preset[word] == pytest.approx(asked[word])


def test_estimate__says_why_a_preset_is_not_offered(api: Api) -> None:
    thin = {**SWEEP, "fixed": {**SWEEP["fixed"], "plate_thickness": "0.1 mm"}, "resolution": 64}
    presets = api.http.post("/v1/sweeps/estimate", json=thin).json()["presets"]
    draft = {preset["name"]: preset for preset in presets}["draft"]
    assert draft["core_seconds"] is None
    assert "half a cell" in draft["reason"]


def test_submit__plans_the_screening_runs_beside_the_points_and_cancel_ends_them(api: Api) -> None:
    sweep = {**SWEEP, "model_part": "screen"}
    points = api.http.post("/v1/sweeps/estimate", json=SWEEP).json()["runs"]
    assert api.http.post("/v1/sweeps/estimate", json=sweep).json()["runs"] == points + 4
    id = api.submit(model_part="screen")
    assert api.http.get(f"/v1/sweeps/{id}").json()["planned"] == points + 4
    rows = api.http.get(f"/v1/sweeps/{id}/runs").json()["items"]
    screens = [row["coordinates"] for row in rows if "screening" in row["coordinates"]]
    names = ["stronger", "weaker", "failure", "equation of state"]
    assert screens == [{"screening": name} for name in names]
    api.http.post(f"/v1/sweeps/{id}/cancel")
    rows = api.http.get(f"/v1/sweeps/{id}/runs").json()["items"]
    assert {row["state"] for row in rows} == {"cancelled"}


def test_submit__of_several_resolutions_and_offsets_plans_each_run(api: Api) -> None:
    id = api.submit(resolution=[8, 16], offsets=3)
    assert api.http.get(f"/v1/sweeps/{id}").json()["planned"] == 12
    points = api.http.get(f"/v1/sweeps/{id}/runs").json()["items"]
    assert points[1]["index"] == [0, 0, 1]
    assert points[1]["coordinates"] == {"speed": 3000.0, "cells_per_diameter": 8.0, "offset": 0.333333333333}
    document = api.http.get(f"/v1/sweeps/{id}/document").json()
    assert (document["resolution"], document["offsets"]) == ([8.0, 16.0], 3)
    assert api.http.post("/v1/sweeps", json=document).json()["reused"] == 12


# --- files ------------------------------------------------------------------------------------------


def test_report__runs_its_own_script_in_a_sandbox_without_network(api: Api) -> None:
    id = api.submit()
    api.compute()
    response = api.http.get(f"/v1/sweeps/{id}/report.html")
    policy = response.headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'unsafe-inline'" in policy
    assert "sandbox allow-scripts" in policy
    assert "allow-same-origin" not in policy
    assert response.headers["X-Content-Type-Options"] == "nosniff"


# --- catalogue and health ---------------------------------------------------------------------------


def test_scenarios__tell_unit_bounds_default_and_meaning(api: Api) -> None:
    items = {item["name"]: item for item in api.http.get("/v1/scenarios").json()["items"]}
    assert {"thin_plate", "thick_plate"} <= set(items)
    parameters = {item["name"]: item for item in items["thin_plate"]["parameters"]}
    assert parameters["speed"]["unit"] == "m s-1"
    assert parameters["speed"]["minimum"] > 0
    assert parameters["speed"]["required"]
    assert parameters["projectile_shape"]["default"] == "sphere"
    assert all(item["meaning"] for item in parameters.values())
