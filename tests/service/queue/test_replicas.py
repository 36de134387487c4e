"""Several services on one database: what the interface of one is told, that of another knows."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from service.records.jobs import Kind
from tests.service.api.test_event_streams import listening
from tests.service.support.api import SWEEP, Api, open_api, served

KEY = {"Idempotency-Key": "the-same"}


@pytest.fixture
def two(postgresql_url: str, tmp_path: Path) -> Iterator[tuple[Api, Api]]:
    with (
        open_api(tmp_path, database_url=postgresql_url) as one,
        open_api(tmp_path, database_url=postgresql_url) as other,
    ):
        other.engine.slots = None  # it does not lead
        yield one, other


def test_submission__to_both_at_once_is_computed_once(two: tuple[Api, Api]) -> None:
    with ThreadPoolExecutor(8) as pool:
        answers = list(
            pool.map(lambda n: two[n % 2].http.post("/v1/sweeps", json=SWEEP).json(), range(8))
        )
    assert sorted(answer["new"] for answer in answers) == [0] * 7 + [2]
    assert all(answer["new"] + answer["reused"] == 2 for answer in answers)
    claims = two[0].store.claim(100, two[0].epoch())
    assert sum(claim.kind is Kind.RUN for claim in claims) == 2


def test_submission__with_one_key_to_both_at_once_is_one_sweep(two: tuple[Api, Api]) -> None:
    def submit(number: int) -> Any:
        return two[number % 2].http.post("/v1/sweeps", json=SWEEP, headers=KEY).json()["id"]

    with ThreadPoolExecutor(8) as pool:
        assert len(set(pool.map(submit, range(8)))) == 1


def test_events__of_the_one_are_told_by_the_other_in_their_order(two: tuple[Api, Api]) -> None:
    one, other = two
    id = one.submit()
    with served(other) as url, listening(url, f"/v1/sweeps/{id}/events") as heard:
        assert next(heard).data["kind"] == "accepted"
        one.compute()
        rest = list(heard)
    assert rest[-1].name == "end"
    numbers = [message.id for message in rest if message.id is not None]
    assert numbers == sorted(set(numbers))
    assert len(numbers) == 6  # two runs and a publication, begun and ended


def test_queue__is_paused_for_both(two: tuple[Api, Api]) -> None:
    one, other = two
    other.http.post("/v1/queue/pause")
    assert one.http.get("/v1/queue").json()["paused"] is not None


def test_file__that_the_one_published_is_sent_by_the_other(two: tuple[Api, Api]) -> None:
    one, other = two
    id = one.submit()
    one.compute()
    path = f"/v1/sweeps/{id}/cube.nc"
    assert other.http.get(path).headers["ETag"] == one.http.get(path).headers["ETag"]
