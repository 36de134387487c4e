"""Sweeps and runs over HTTP: submitted, listed, estimated, deleted."""

from contextlib import closing

from service.store import Store
from studies.sweeps import examples
from tests.service.support.api import FILES, SWEEP, Api

MORE = {**SWEEP, "axes": {"speed": ["6 km/s", "7 km/s"]}}


def test_submission__is_stored_before_the_response_that_says_where_it_is(api: Api) -> None:
    response = api.http.post("/v1/sweeps", json=SWEEP)
    sweep = response.json()
    assert response.status_code == 202
    assert response.headers["Location"] == sweep["links"]["self"]
    assert int(response.headers["Retry-After"]) > 0
    with closing(Store.open(api.settings.url)) as other:
        assert other.sweeps.get(sweep["id"]).planned == 2
    again = api.http.post("/v1/sweeps", json=MORE).json()
    assert [again[name] for name in ("planned", "reused", "new")] == [2, 1, 1]


def test_submission__takes_each_example_as_yaml_and_its_document_again(api: Api) -> None:
    headers = {"Content-Type": "application/yaml"}
    for name in examples.names():
        response = api.http.post("/v1/sweeps", content=examples.text(name), headers=headers)
        assert response.status_code == 202, response.text
        sweep = response.json()
        assert sweep["name"] == name
        document = api.http.get(sweep["links"]["document"]).json()
        assert api.http.post("/v1/sweeps", json=document).json()["reused"] == sweep["planned"]


def test_sweep__shows_counts_progress_and_links_that_lead_somewhere(api: Api) -> None:
    here = f"/v1/sweeps/{api.submit()}"
    sweep = api.http.get(here).json()
    assert (sweep["state"], sweep["counts"]["queued"], sweep["progress"]) == ("queued", 2, 0)
    assert "cancel" in sweep["links"]
    assert not {"retry", *FILES} & set(sweep["links"])
    for name in ("self", "runs", "document", "history"):
        assert api.http.get(sweep["links"][name]).status_code == 200
    api.compute()
    sweep = api.http.get(here).json()
    assert sweep["state"] == "succeeded"
    assert {name: api.http.get(sweep["links"][name]).content for name in FILES} == FILES


def test_sweeps__are_listed_page_by_page(api: Api) -> None:
    ids = [api.submit(name=f"sweep-{number}") for number in range(5)]
    received: list[str] = []
    there: str | None = "/v1/sweeps?limit=2&state=queued"
    while there is not None:
        page = api.http.get(there)
        received += [sweep["id"] for sweep in page.json()["items"]]
        there = page.links.get("next", {}).get("url")
    assert received == ids[::-1]


def test_run__shows_its_question_its_measurements_or_why_it_failed(api: Api) -> None:
    here = f"/v1/sweeps/{api.submit()}"
    api.compute(failures=1)
    [failed] = api.http.get(f"{here}/runs?state=failed").json()["items"]
    assert failed["coordinates"] == {"speed": 3000.0}
    assert "particle 17" in failed["run"]["reason"]
    [point] = api.http.get(f"{here}/runs?state=succeeded").json()["items"]
    run = api.http.get(point["run"]["links"]["self"]).json()
    assert run["question"]["parameters"]["projectile_diameter"] == 0.008
    assert run["summary"]["measurements"]["hole_diameter"]["value"] == 0.0148
    assert "path" not in run


def test_pin__keeps_a_sweep_however_often_it_is_set(api: Api) -> None:
    here = f"/v1/sweeps/{api.submit()}"
    api.compute()
    first, second = (api.http.put(f"{here}/pin").json() for _ in range(2))
    assert first["pinned"] == second["pinned"] == api.http.get(here).json()["pinned"] is not None
    refused = api.http.delete(here)
    assert (refused.status_code, "unpin it" in refused.json()["detail"]) == (409, True)
    assert [api.http.delete(f"{here}/pin").json()["pinned"] for _ in range(2)] == [None, None]
    kinds = [event["kind"] for event in api.http.get(f"{here}/history").json()["items"]]
    assert (kinds.count("pinned"), kinds.count("unpinned")) == (1, 1)
    assert api.http.delete(here).status_code == 204
    assert api.http.put(f"{here}/pin").status_code == 404


def test_delete__is_refused_before_a_sweep_has_ended(api: Api) -> None:
    here = f"/v1/sweeps/{api.submit()}"
    refused = api.http.delete(here)
    assert refused.status_code == 409
    assert "cancel" in refused.json()["detail"]
    [first, _] = api.store.leases.take(2, api.term())
    api.store.leases.finish(first, api.result(first.id))  # so that there is something to publish
    api.http.post(f"{here}/cancel")
    refused = api.http.delete(here)
    assert refused.status_code == 409
    assert refused.json()["detail"] == "the sweep is cancelling; delete it once it is cancelled"
    assert api.http.get(here).status_code == 200


def test_estimate__counts_and_stores_nothing(api: Api) -> None:
    api.submit()
    cost = api.http.post("/v1/sweeps/estimate", json=MORE).json()
    assert (cost["runs"], cost["reused"]) == (2, 1)
    assert cost["core_seconds"] > 0
    assert cost["bytes"] > 0
    assert len(api.http.get("/v1/sweeps").json()["items"]) == 1
