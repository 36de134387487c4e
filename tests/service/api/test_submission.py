"""What is said about a sweep when it is submitted: key against doubles, priority, what is kept."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from tests.service.support.api import SWEEP, Api, open_api, sweep_of

KEY = "8e03978e-40d5-43dd-bc93-6894a57f9324"


@pytest.fixture
def api(tmp_path: Path) -> Iterator[Api]:
    with open_api(tmp_path) as opened:
        yield opened


def submit(api: Api, document: Any = SWEEP, *, key: str | None = None, query: str = "") -> Any:
    headers = {} if key is None else {"Idempotency-Key": key}
    return api.http.post(f"/v1/sweeps{query}", json=document, headers=headers)


def listed(api: Api) -> list[Any]:
    return api.http.get("/v1/sweeps").json()["items"]


# --- Idempotency-Key ------------------------------------------------------------------------------


def test_key__sent_twice_is_one_sweep(api: Api) -> None:
    first, second = submit(api, key=KEY), submit(api, key=KEY)
    assert (first.status_code, second.status_code) == (202, 202)
    assert first.headers["Location"] == second.headers["Location"]
    assert first.json() == second.json()
    assert len(listed(api)) == 1


def test_key__of_many_at_once_is_one_sweep(api: Api) -> None:
    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(lambda _: submit(api, key=KEY), range(8)))
    assert {answer.status_code for answer in answers} == {202}
    assert len({answer.json()["id"] for answer in answers}) == 1
    assert len(listed(api)) == 1


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


def test_key__in_quotes_is_the_same_key(api: Api) -> None:
    assert submit(api, key=f'"{KEY}"').json()["id"] == submit(api, key=KEY).json()["id"]


@pytest.mark.parametrize("key", ["", '""', "two words", "x" * 201, "tab\tin it"])
def test_key__that_is_none_is_refused(api: Api, key: str) -> None:
    refused = submit(api, key=key)
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["field"] == "Idempotency-Key"
    assert listed(api) == []


# --- priority and retention -------------------------------------------------------------------------


def test_priority_and_keep__are_said_in_the_query_and_answered(api: Api) -> None:
    accepted = submit(api, query="?priority=-7&keep=film").json()
    assert (accepted["priority"], accepted["keep"]) == (-7, "film")
    assert (submit(api).json()["priority"], submit(api).json()["keep"]) == (0, "final")


def test_priority_and_keep__are_no_part_of_the_question(api: Api) -> None:
    id = submit(api, query="?priority=9&keep=numbers").json()["id"]
    document = api.http.get(f"/v1/sweeps/{id}/document").json()
    assert not {"priority", "keep"} & set(document)
    assert submit(api, document).json()["reused"] == 2


@pytest.mark.parametrize(
    ("query", "field"),
    [
        ("?priority=101", "query.priority"),
        ("?priority=-101", "query.priority"),
        ("?priority=soon", "query.priority"),
        ("?priority=1.5", "query.priority"),
        ("?keep=everything", "query.keep"),
    ],
)
def test_wrong_word__is_refused_and_stores_nothing(api: Api, query: str, field: str) -> None:
    refused = submit(api, query=query)
    assert refused.status_code == 422
    [error] = refused.json()["errors"]
    assert error["field"] == field
    assert all(error[word] for word in ("value", "limit", "cure"))
    assert listed(api) == []


# --- change -----------------------------------------------------------------------------------------


def test_change__gives_another_priority(api: Api) -> None:
    first, second = api.submit(), api.submit(axes={"speed": ["7 km/s"]})
    changed = api.http.patch(f"/v1/sweeps/{second}", json={"priority": -5})
    assert (changed.status_code, changed.json()["priority"]) == (200, -5)
    [claim] = api.store.lease(1, api.term())
    assert claim.id == api.store.sweep_runs(second).items[0].run.id
    assert api.store.sweep(first).priority == 0


@pytest.mark.parametrize(
    ("body", "field"),
    [
        (b'{"priority": 101}', "priority"),
        (b'{"priority": "5"}', "priority"),
        (b'{"priority": true}', "priority"),
        (b'{"priority": 1.0}', "priority"),
        (b'{"priority": null}', "priority"),
        (b'{"priority": 1e999}', "priority"),
        (b'{"priority": NaN}', "priority"),
        (b'{"priority": ' + b"1" * 30 + b"}", "priority"),
        (b'{"priority": ' + b"1" * 5000 + b"}", "document"),
        (b'{"priority": 1, "priority": 2}', "document"),
        (b'{"priority": 1, "owner": "me"}', "owner"),
        (b"{}", "priority"),
        (b"[]", "document"),
        (b"", "document"),
        (b"[" * 100_000, "document"),
    ],
)
def test_change__that_says_nothing_clear_is_refused(api: Api, body: bytes, field: str) -> None:
    id = api.submit()
    headers = {"Content-Type": "application/json"}
    refused = api.http.patch(f"/v1/sweeps/{id}", content=body, headers=headers)
    assert refused.status_code == 422, refused.text
    assert refused.json()["errors"][0]["field"] == field
    assert all(refused.json()["errors"][0][word] for word in ("value", "limit", "cure"))
    assert api.store.sweep(id).priority == 0


def test_change__of_another_media_type_is_a_415(api: Api) -> None:
    id = api.submit()
    headers = {"Content-Type": "application/yaml"}
    refused = api.http.patch(f"/v1/sweeps/{id}", content="priority: 1", headers=headers)
    assert refused.status_code == 415


def test_change__of_a_sweep_that_has_ended_is_a_conflict(api: Api) -> None:
    id = api.submit()
    api.compute()
    refused = api.http.patch(f"/v1/sweeps/{id}", json={"priority": 1})
    assert refused.status_code == 409
    assert "succeeded" in refused.json()["detail"]


def test_delete__of_a_sweep_that_is_being_cancelled_says_what_to_do(api: Api) -> None:
    id = api.submit(resolution=9)
    mine = {point.run.id for point in api.store.sweep_runs(id).items}
    leases = [lease for lease in api.store.lease(1000, api.term()) if lease.id in mine]
    api.store.finish(leases[0], api.result(leases[0].id))  # so that there is something to publish
    api.http.post(f"/v1/sweeps/{id}/cancel")
    refused = api.http.delete(f"/v1/sweeps/{id}")
    assert refused.status_code == 409
    assert refused.json()["detail"] == "the sweep is cancelling; delete it once it is cancelled"
