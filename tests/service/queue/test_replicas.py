"""Several services on one database: what one of them is sent, the others serve."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from service.records.jobs import Kind
from tests.service.support.api import SWEEP, Api, open_api

KEY = {"Idempotency-Key": "the-same"}


@pytest.fixture
def two(postgresql_url: str, tmp_path: Path) -> Iterator[tuple[Api, Api]]:
    with (
        open_api(tmp_path, database_url=postgresql_url) as leader,
        open_api(tmp_path, database_url=postgresql_url) as other,
    ):
        other.engine.slots = None  # it does not lead
        yield leader, other


@pytest.mark.parametrize("headers", [{}, KEY])
def test_submission__to_both_at_once_is_computed_once(two: tuple[Api, Api], headers: dict[str, str]) -> None:
    def submit(number: int) -> dict[str, int]:
        return two[number % 2].http.post("/v1/sweeps", json=SWEEP, headers=headers).json()

    with ThreadPoolExecutor(8) as pool:
        answers = list(pool.map(submit, range(8)))
    assert len({answer["id"] for answer in answers}) == (1 if headers else 8)
    assert all(answer["new"] + answer["reused"] == 2 for answer in answers)
    leases = two[0].store.lease(100, two[0].term())
    assert sum(lease.kind is Kind.RUN for lease in leases) == 2


def test_pause_and_files__of_one_service_are_those_of_the_other(two: tuple[Api, Api]) -> None:
    leader, other = two
    path = f"/v1/sweeps/{leader.submit()}/cube.nc"
    leader.compute()
    assert other.http.get(path).headers["ETag"] == leader.http.get(path).headers["ETag"]
    other.http.post("/v1/queue/pause")
    assert leader.http.get("/v1/queue").json()["paused"] is not None
