"""What a submission and a change state beside the document: idempotency key, priority, retention."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

from service.api import dependencies
from tests.service.support.api import SWEEP, Api, sweep_of

KEY = "8e03978e-40d5-43dd-bc93-6894a57f9324"


def submit(api: Api, document: Any = SWEEP, *, key: str | None = None, query: str = "") -> Any:
    headers = {} if key is None else {"Idempotency-Key": key}
    return api.http.post(f"/v1/sweeps{query}", json=document, headers=headers)


def listed(api: Api) -> list[Any]:
    return api.http.get("/v1/sweeps").json()["items"]


def refused_field(response: Any) -> str:
    """The field of the first error of a refusal that says everything."""
    assert response.status_code == 422, response.text
    error = response.json()["errors"][0]
    assert all(error[name] for name in ("value", "limit", "cure"))
    return error["field"]


def test_key__of_many_requests_is_one_sweep(api: Api) -> None:
    with ThreadPoolExecutor(8) as pool:
        responses = list(pool.map(lambda key: submit(api, key=key), [KEY, f'"{KEY}"'] * 4))
    assert {response.status_code for response in responses} == {202}
    assert len({response.headers["Location"] for response in responses}) == 1
    assert all(response.json() == responses[0].json() for response in responses)
    assert len(listed(api)) == 1


def test_key__of_an_accepted_sweep_is_that_sweep_on_a_disk_that_is_full_now(
    api: Api, monkeypatch: pytest.MonkeyPatch
) -> None:
    accepted = submit(api, key=KEY).json()
    monkeypatch.setattr(dependencies, "free_bytes", lambda _: api.settings.disk_reserve + 1)
    assert submit(api, key=KEY).json()["id"] == accepted["id"]
    assert refused_field(submit(api)) == "disk"


@pytest.mark.parametrize(
    "again", [{"document": sweep_of(name="another")}, {"query": "?priority=5"}, {"query": "?keep=film"}]
)
def test_key__with_another_request_is_refused_and_stores_nothing(api: Api, again: dict[str, Any]) -> None:
    submit(api, key=KEY)
    refused = submit(api, key=KEY, **again)
    assert refused.status_code == 422
    assert refused.json()["type"].endswith("idempotency-key-reused")
    assert KEY in refused.json()["detail"]
    assert len(listed(api)) == 1


def test_priority_and_keep__are_stated_in_the_query_and_no_part_of_the_question(api: Api) -> None:
    accepted = submit(api, query="?priority=-7&keep=film").json()
    assert (accepted["priority"], accepted["keep"]) == (-7, "film")
    document = api.http.get(accepted["links"]["document"]).json()
    assert not {"priority", "keep"} & set(document)
    again = submit(api, document).json()
    assert (again["priority"], again["keep"], again["reused"]) == (0, "final", 2)


def test_change__gives_another_priority_until_the_sweep_has_ended(api: Api) -> None:
    first, second = api.submit(), api.submit(axes={"speed": ["7 km/s"]})
    changed = api.http.patch(f"/v1/sweeps/{second}", json={"priority": -5})
    assert (changed.status_code, changed.json()["priority"]) == (200, -5)
    [lease] = api.store.leases.take(1, api.term())
    assert lease.id == api.store.sweeps.points(second).items[0].run.id
    assert api.store.sweeps.get(first).priority == 0
    api.store.leases.finish(lease, api.result(lease.id))
    api.compute()
    refused = api.http.patch(f"/v1/sweeps/{second}", json={"priority": 1})
    assert refused.status_code == 409
    assert "succeeded" in refused.json()["detail"]
