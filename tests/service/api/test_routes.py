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


def test_list__pages_through_every_sweep_youngest_first(api: Api) -> None:
    ids = [api.submit(name=f"sweep-{number}") for number in range(5)]
    seen: list[str] = []
    cursor: dict[str, str] = {}
    while True:
        page = api.http.get("/v1/sweeps", params={"limit": 2, **cursor}).json()
        seen += [sweep["id"] for sweep in page["items"]]
        if page["next_cursor"] is None:
            break
        cursor = {"cursor": page["next_cursor"]}
    assert seen == ids[::-1]


def test_list__names_the_next_page_in_a_link(api: Api) -> None:
    ids = [api.submit(name=f"sweep-{number}") for number in range(5)]
    seen: list[str] = []
    there: str | None = "/v1/sweeps?limit=2&state=queued"
    while there is not None:
        answer = api.http.get(there)
        seen += [sweep["id"] for sweep in answer.json()["items"]]
        there = answer.links.get("next", {}).get("url")
    assert seen == ids[::-1]


def test_runs__can_be_asked_by_state(api: Api) -> None:
    id = api.submit()
    api.compute(failures=1)
    failed = api.http.get(f"/v1/sweeps/{id}/runs?state=failed").json()["items"]
    assert [point["coordinates"] for point in failed] == [{"speed": 3000.0}]
    assert "particle 17" in failed[0]["run"]["reason"]


def test_runs__page_in_the_order_of_the_sweep(api: Api) -> None:
    id = api.submit(axes={"speed": {"start": "2 km/s", "stop": "6 km/s", "step": "1 km/s"}})
    first = api.http.get(f"/v1/sweeps/{id}/runs?limit=3").json()
    rest = api.http.get(f"/v1/sweeps/{id}/runs", params={"cursor": first["next_cursor"]}).json()
    ordinals = [point["ordinal"] for point in first["items"] + rest["items"]]
    assert ordinals == [0, 1, 2, 3, 4]


def test_run__shows_its_whole_question_and_its_measurements(api: Api) -> None:
    id = api.submit()
    api.compute()
    point = api.http.get(f"/v1/sweeps/{id}/runs").json()["items"][0]
    run = api.http.get(point["run"]["links"]["self"]).json()
    assert run["question"]["parameters"]["projectile_diameter"] == 0.008
    assert run["summary"]["measurements"]["hole_diameter"]["value"] == 0.0148
    assert "path" not in run


def test_run__says_null_for_what_is_not_a_number(api: Api) -> None:
    id = api.submit()
    api.compute()
    run = api.http.get(f"/v1/sweeps/{id}/runs").json()["items"][0]["run"]
    assert run["summary"]["measurements"]["hole_diameter"]["uncertainty"] is None


# --- order ------------------------------------------------------------------------------------------


def test_cancel__ends_a_sweep_and_can_be_repeated(api: Api) -> None:
    id = api.submit()
    for _ in range(2):
        response = api.http.post(f"/v1/sweeps/{id}/cancel")
        assert response.status_code == 202
    assert api.http.get(f"/v1/sweeps/{id}").json()["counts"]["cancelled"] == 2


def test_retry__queues_what_an_accident_ended(api: Api) -> None:
    id = api.submit()
    api.compute(failures=1)
    retried = api.http.post(f"/v1/sweeps/{id}/retry").json()
    assert retried["counts"]["queued"] == 1
    assert retried["counts"]["succeeded"] == 1


def test_delete__is_refused_while_a_sweep_runs(api: Api) -> None:
    id = api.submit()
    response = api.http.delete(f"/v1/sweeps/{id}")
    assert response.status_code == 409
    assert "cancel" in response.json()["detail"]
    assert api.http.get(f"/v1/sweeps/{id}").status_code == 200


def test_delete__forgets_a_sweep_that_has_ended(api: Api) -> None:
    id = api.submit()
    api.compute()
    assert api.http.delete(f"/v1/sweeps/{id}").status_code == 204
    assert api.http.get(f"/v1/sweeps/{id}").status_code == 404


def test_estimate__counts_and_stores_nothing(api: Api) -> None:
    api.submit()
    more = {**SWEEP, "axes": {"speed": ["6 km/s", "7 km/s"]}}
    answer = api.http.post("/v1/sweeps/estimate", json=more).json()
    assert (answer["runs"], answer["reused"]) == (2, 1)
    assert answer["core_seconds"] > 0
    assert answer["bytes"] > 0
    assert len(api.http.get("/v1/sweeps").json()["items"]) == 1


def test_estimate__shows_what_each_accuracy_would_cost(api: Api) -> None:
    presets = api.http.post("/v1/sweeps/estimate", json=SWEEP).json()["presets"]
    assert [preset["name"] for preset in presets] == list(ACCURACY)
    for preset in presets:
        at = {key: value for key, value in SWEEP.items() if key != "resolution"}
        asked = api.http.post("/v1/sweeps/estimate", json=at | {"accuracy": preset["name"]}).json()
        for word in ("runs", "core_seconds", "bytes"):
            assert preset[word] == pytest.approx(asked[word])


def test_estimate__offers_no_preset_where_the_resolution_is_an_axis(api: Api) -> None:
    axes = {**SWEEP["axes"], "cells_per_diameter": [8, 16]}
    own = {**SWEEP, "axes": axes}
    del own["resolution"]
    assert api.http.post("/v1/sweeps/estimate", json=own).json()["presets"] == []


def test_estimate__says_why_a_preset_is_not_offered(api: Api) -> None:
    thin = {**SWEEP, "fixed": {**SWEEP["fixed"], "plate_thickness": "0.1 mm"}, "resolution": 64}
    presets = api.http.post("/v1/sweeps/estimate", json=thin).json()["presets"]
    draft = {preset["name"]: preset for preset in presets}["draft"]
    assert draft["core_seconds"] is None
    assert "half a cell" in draft["reason"]


def test_submit__of_several_resolutions_and_offsets_plans_each_run(api: Api) -> None:
    id = api.submit(resolution=[8, 16], offsets=3)
    assert api.http.get(f"/v1/sweeps/{id}").json()["planned"] == 12
    points = api.http.get(f"/v1/sweeps/{id}/runs").json()["items"]
    assert points[1]["index"] == [0, 0, 1]
    assert points[1]["coordinates"] == {
        "speed": 3000.0,
        "cells_per_diameter": 8.0,
        "offset": 0.333333333333,
    }
    document = api.http.get(f"/v1/sweeps/{id}/document").json()
    assert (document["resolution"], document["offsets"]) == ([8.0, 16.0], 3)
    assert api.http.post("/v1/sweeps", json=document).json()["reused"] == 12


# --- files ------------------------------------------------------------------------------------------


@pytest.fixture
def published(api: Api) -> str:
    """The address of a sweep with files."""
    id = api.submit(name="Ärger/../x")
    api.compute()
    return f"/v1/sweeps/{id}"


@pytest.mark.parametrize("name", FILES)
def test_file__has_a_strong_tag_and_is_not_sent_twice(api: Api, published: str, name: str) -> None:
    first = api.http.get(f"{published}/{name}")
    tag = first.headers["ETag"]
    assert tag.startswith('"')
    assert len(tag) == 64 + 2
    for known in (tag, f'"other", {tag}', "*"):
        again = api.http.get(f"{published}/{name}", headers={"If-None-Match": known})
        assert (again.status_code, again.content) == (304, b"")
        assert again.headers["ETag"] == tag
    assert api.http.get(f"{published}/{name}", headers={"If-None-Match": '"x"'}).status_code == 200


@pytest.mark.parametrize("name", FILES)
def test_file__head_answers_the_headers_alone(api: Api, published: str, name: str) -> None:
    response = api.http.head(f"{published}/{name}")
    assert response.status_code == 200
    assert response.content == b""
    assert int(response.headers["Content-Length"]) == len(FILES[name])


def test_file__is_sent_in_part_where_the_copy_is_the_same(api: Api, published: str) -> None:
    tag = api.http.head(f"{published}/cube.nc").headers["ETag"]
    part = {"Range": "bytes=1-3", "If-Range": tag}
    response = api.http.get(f"{published}/cube.nc", headers=part)
    assert (response.status_code, response.content) == (206, b"HDF")
    whole = api.http.get(f"{published}/cube.nc", headers=part | {"If-Range": '"old"'})
    assert (whole.status_code, whole.content) == (200, FILES["cube.nc"])


def test_file__is_offered_under_a_plain_name(api: Api, published: str) -> None:
    disposition = api.http.get(f"{published}/cube.nc").headers["Content-Disposition"]
    assert disposition == 'attachment; filename="rger-..-x-cube.nc"'


def test_report__runs_its_own_script_in_a_sandbox_without_network(api: Api, published: str) -> None:
    response = api.http.get(f"{published}/report.html")
    policy = response.headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy
    assert "script-src 'unsafe-inline'" in policy
    assert "sandbox allow-scripts" in policy
    assert "allow-same-origin" not in policy
    assert response.headers["X-Content-Type-Options"] == "nosniff"


def test_file__of_an_unfinished_sweep_is_a_409_that_says_how_far_it_is(api: Api) -> None:
    response = api.http.get(f"/v1/sweeps/{api.submit()}/cube.nc")
    assert response.status_code == 409
    assert response.json()["type"].endswith("not-ready")
    assert "queued" in response.json()["detail"]


def test_file__that_was_removed_by_hand_is_a_404(api: Api, published: str) -> None:
    for file in api.settings.data.rglob("cube.nc"):
        file.unlink()
    assert api.http.get(f"{published}/cube.nc").status_code == 404


# --- catalogue and health ---------------------------------------------------------------------------


def test_scenarios__tell_unit_bounds_default_and_meaning(api: Api) -> None:
    items = {one["name"]: one for one in api.http.get("/v1/scenarios").json()["items"]}
    assert {"thin_plate", "thick_plate"} <= set(items)
    parameters = {one["name"]: one for one in items["thin_plate"]["parameters"]}
    assert parameters["speed"]["unit"] == "m s-1"
    assert parameters["speed"]["minimum"] > 0
    assert parameters["speed"]["required"]
    assert parameters["projectile_shape"]["default"] == "sphere"
    assert all(one["meaning"] for one in parameters.values())


def test_materials__carry_unit_source_and_confidence(api: Api) -> None:
    items = {one["name"]: one for one in api.http.get("/v1/materials").json()["items"]}
    assert {"value", "unit", "source", "confidence"} == set(items["copper-ofhc"]["density"])


def test_accuracies__carry_resolutions_offsets_and_meaning(api: Api) -> None:
    items = {one["name"]: one for one in api.http.get("/v1/accuracies").json()["items"]}
    assert list(items) == list(ACCURACY)
    assert items["fine"]["resolutions"] == list(ACCURACY["fine"].resolutions)
    assert items["fine"]["offsets"] == ACCURACY["fine"].offsets
    assert all(one["meaning"] for one in items.values())


def test_recipes__say_what_they_fill_in(api: Api) -> None:
    items = {one["name"]: one for one in api.http.get("/v1/recipes").json()["items"]}
    assert {"whipple", "thesis"} <= set(items)
    assert items["thesis"]["shape"] == "linear"


def test_laws__carry_equation_source_and_range(api: Api) -> None:
    for law in api.http.get("/v1/laws").json()["items"]:
        assert law["equation"]
        assert law["source"]
        assert law["range"]


def test_version__names_the_physics(api: Api) -> None:
    assert api.http.get("/version").json()["physics_version"] >= 1
