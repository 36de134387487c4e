"""A store with much history: the rows of a sweep that was computed, again and again under other ids."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from datetime import datetime, timedelta
from typing import Any

import sqlalchemy as sa

from service.records.jobs import Kind, Submission
from service.store import Store
from service.store.tables import ARTIFACTS, EVENTS, JOBS, POINTS, SWEEPS, batches, now
from studies.quantities.files import RESULT, SECTIONS, STATE
from tests.service.support.fakes import runs_of, stored, sweep_of
from tests.service.support.rows import TERM, result

OWNERS = ("anna", "ben", "carla", "")
OF_A_PUBLICATION = ("cube.nc", "runs.csv", "report.html", "report.json", "log.txt")
PARAMETERS = {f"parameter_{number}": number * 1.25 for number in range(60)}
SIZE = 1000  # bytes of a file
Rows = dict[sa.Table, list[dict[str, Any]]]


@dataclass(frozen=True)
class History:
    """How much has happened."""

    sweeps: int = 10_000
    runs_of_a_sweep: int = 10
    abandoned: int = 10_000  # runs whose sweeps were deleted
    seconds_ago: float = 86_400.0

    @property
    def files(self) -> int:
        return self.sweeps * (len(OF_A_PUBLICATION) + 3 * self.runs_of_a_sweep)


def write(store: Store, history: History) -> None:
    """Write a history into a store that has none."""
    first, moment = _computed(store, history), now() - timedelta(seconds=history.seconds_ago)
    [run, *_] = [job for job in first[JOBS] if job["kind"] is Kind.RUN]
    left = {**run, "abandoned": moment, "bytes": 0}
    with store.database.writing() as connection:
        for table in (SWEEPS, JOBS, POINTS, ARTIFACTS, EVENTS):
            rows = (row for number in range(1, history.sweeps) for row in _again(first[table], number, moment))
            for batch in batches(rows):
                connection.execute(table.insert(), batch)
        abandoned = (row for number in range(history.abandoned) for row in _again([left], -1 - number, moment))
        for batch in batches(abandoned):
            connection.execute(JOBS.insert(), batch)


def _computed(store: Store, history: History) -> Rows:
    """The rows of a sweep that was computed and published."""
    store.sweeps.create(Submission(sweep_of(runs_of(*["fine"] * history.runs_of_a_sweep, first=1 << 90, **PARAMETERS))))
    while leases := store.leases.take(100, TERM):
        for lease in leases:
            names = OF_A_PUBLICATION if lease.kind is Kind.PUBLISH else (RESULT, SECTIONS, STATE)
            files = tuple(replace(stored(name, f"{lease.id}/{name}"), size=SIZE) for name in names)
            if lease.kind is Kind.PUBLISH:
                store.leases.publish(lease, files, seconds=1.0)
            else:
                store.leases.finish(lease, replace(result(), files=files))
    with store.database.reading() as connection:
        tables = (SWEEPS, JOBS, POINTS, ARTIFACTS, EVENTS)
        return {table: [dict(row._mapping) for row in connection.execute(sa.select(table))] for table in tables}


def _again(rows: list[dict[str, Any]], number: int, moment: datetime) -> Iterator[dict[str, Any]]:
    """These rows of another sweep: its ids, its owner, and the moment at which all of it was."""
    owner = OWNERS[number % len(OWNERS)]
    for row in rows:
        copy = {name: value for name, value in row.items() if name != "number"}
        for name in copy.keys() & {"id", "sweep_id", "job_id", "run_id"}:
            copy[name] = copy[name] and hashlib.sha256(f"{number} {copy[name]}".encode()).hexdigest()[:32]
        copy |= {name: moment for name, value in row.items() if isinstance(value, datetime)}
        yield {**copy, "owner": owner} if "owner" in row else copy


def analyze(store: Store) -> None:
    """Let the database take statistics of its tables, as an operator may."""
    with store.database.writing() as connection:
        connection.exec_driver_sql("ANALYZE")
