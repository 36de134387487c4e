"""Kill -9 of every kind of process, and of a service at every named point: nothing is lost."""

from collections.abc import Iterator

from tests.acceptance.checks import fault_points as points
from tests.acceptance.checks import kills
from tests.claims import Row, claim
from tests.service.support.databases import postgresql_server


@claim(
    "kills-sqlite",
    says="40 kills -9 over 200 runs on SQLite: one registered result a run, with the bits of one that nobody disturbed",
)
def kills_sqlite() -> Iterator[Row]:
    yield from kills.crash_test_rows(kills.FULL)


@claim(
    "kills-postgresql",
    says="50 kills -9 on PostgreSQL and a Dask cluster, whose workers and scheduler are killed too: the same",
)
def kills_postgresql() -> Iterator[Row]:
    yield from kills.crash_test_rows(kills.FULL_EXTERNAL)


@claim(
    "fault-points",
    says="a service that dies at a named point leaves a consistent store and no half file, and the next one goes on",
)
def fault_points() -> Iterator[Row]:
    yield from points.of_a_service("sqlite", None)
    with postgresql_server() as server, server.database() as url:
        yield from points.of_a_service("postgresql", url)
    yield from points.of_a_copy()
