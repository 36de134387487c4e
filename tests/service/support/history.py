"""A store with much history: sweeps, runs and files that were never computed, as rows alone."""

import hashlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import timedelta
from itertools import islice
from typing import Any

import sqlalchemy as sa

from service.records.jobs import Keep, Kind, State
from service.store import Store
from service.store.tables import ARTIFACTS, EVENTS, JOBS, POINTS, PUBLISH_PRIORITY, SWEEPS, count_bytes, now
from solver import PHYSICS_VERSION
from studies.quantities.files import RESULT, SECTIONS, STATE

OWNERS = ("anna", "ben", "carla", "")
OF_A_PUBLICATION = ("cube.nc", "runs.csv", "report.html", "report.json", "log.txt")
SPEC = {"scenario": "thin_plate", "parameters": {f"parameter_{number}": number * 1.25 for number in range(60)}}
SUMMARY = {"measurements": {"hole_diameter": {"value": 0.0148, "uncertainty": 1e-4, "flags": []}}, "numbers": {}}
BATCH = 2000  # rows of a statement
SIZE = 1000  # bytes of a file


@dataclass(frozen=True)
class History:
    """How much has happened."""

    sweeps: int = 10_000
    runs_of_a_sweep: int = 10
    abandoned: int = 10_000  # runs whose sweeps were deleted
    seconds_ago: float = 86_400.0

    @property
    def jobs(self) -> int:
        return self.sweeps * (1 + self.runs_of_a_sweep) + self.abandoned

    @property
    def files(self) -> int:
        return self.sweeps * (len(OF_A_PUBLICATION) + 3 * self.runs_of_a_sweep)


def write(store: Store, history: History) -> None:
    """Write the rows of a history into a store."""
    moment = now() - timedelta(seconds=history.seconds_ago)
    for table, rows in (
        (SWEEPS, (_sweep(number, history, moment) for number in range(history.sweeps))),
        (JOBS, _jobs(history, moment)),
        (POINTS, _points(history)),
        (ARTIFACTS, _files(history)),
        (EVENTS, _events(history, moment)),
    ):
        remaining: Iterator[dict[str, Any]] = iter(rows)
        with store.database.writing() as connection:
            while batch := list(islice(remaining, BATCH)):
                connection.execute(table.insert(), batch)
    with store.database.writing() as connection:
        count_bytes(connection, sa.true())


def analyze(store: Store) -> None:
    """Let the database take statistics of its tables, as an operator may."""
    with store.database.writing() as connection:
        connection.exec_driver_sql("ANALYZE")


def sweep_id(number: int) -> str:
    return _id(f"sweep {number}")


def run_id(number: int) -> str:
    return _id(f"run {number}")


def _id(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _publication_id(number: int) -> str:
    return _id(f"publication {number}")


def _owner(sweep: int) -> str:
    return OWNERS[sweep % len(OWNERS)]


def _sweep(number: int, history: History, moment: Any) -> dict[str, Any]:
    id = sweep_id(number)
    return {
        "id": id,
        "name": f"sweep-{number}",
        "title": f"Sweep {number}",
        "scenario": "thin_plate",
        "document": {"name": f"sweep-{number}", "fixed": {"projectile": "copper-ofhc"}},
        "digest": id * 2,
        "owner": _owner(number),
        "priority": 0,
        "keep": Keep.FINAL,
        "planned": history.runs_of_a_sweep,
        "new": history.runs_of_a_sweep,
        "created": moment,
        "physics": PHYSICS_VERSION,
    }


def _job(id: str, kind: Kind, owner: str, moment: Any, **more: Any) -> dict[str, Any]:
    plain: dict[str, Any] = dict.fromkeys(("sweep_id", "scenario", "spec", "path", "size", "sha256", "summary"))
    return {
        **plain,
        "id": id,
        "kind": kind,
        "state": State.SUCCEEDED,
        "priority": 0,
        "owner": owner,
        "virtual_time": 1.0,
        "ordinal": 0,
        "keep": Keep.FINAL,
        "cost": 10.0,
        "attempt": 1,
        "term": 1,
        "token": "c0ffee00",
        "crashes": 0,
        "bytes": 0,
        "fraction": 1.0,
        "seconds": 12.5,
        "created": moment,
        "queued": moment,
        "started": moment,
        "finished": moment,
        "abandoned": None,
        **more,
    }


def _jobs(history: History, moment: Any) -> Iterator[dict[str, Any]]:
    for sweep in range(history.sweeps):
        of_sweep = {"sweep_id": sweep_id(sweep), "priority": PUBLISH_PRIORITY, "keep": Keep.NUMBERS}
        yield _job(_publication_id(sweep), Kind.PUBLISH, _owner(sweep), moment, **of_sweep)
    with_points = history.sweeps * history.runs_of_a_sweep
    for run in range(with_points + history.abandoned):
        id = run_id(run)
        of_run = {"scenario": "thin_plate", "spec": SPEC, "summary": SUMMARY, "path": f"runs/{id}/{RESULT}"}
        left = {"abandoned": moment, "keep": Keep.NUMBERS} if run >= with_points else {}
        owner = _owner(run // history.runs_of_a_sweep)
        yield _job(id, Kind.RUN, owner, moment, size=SIZE, sha256=id * 2, **of_run, **left)


def _points(history: History) -> Iterator[dict[str, Any]]:
    for sweep in range(history.sweeps):
        for place in range(history.runs_of_a_sweep):
            yield {
                "sweep_id": sweep_id(sweep),
                "ordinal": place,
                "run_id": run_id(sweep * history.runs_of_a_sweep + place),
                "axis_index": [place],
                "coordinates": {"speed": 1000.0 + place},
                "detached": False,
            }


def _files(history: History) -> Iterator[dict[str, Any]]:
    for sweep in range(history.sweeps):
        yield from _files_of(_publication_id(sweep), OF_A_PUBLICATION)
    for run in range(history.sweeps * history.runs_of_a_sweep):
        yield from _files_of(run_id(run), (RESULT, SECTIONS, STATE))


def _files_of(job: str, names: Sequence[str]) -> Iterator[dict[str, Any]]:
    for name in names:
        yield {"job_id": job, "name": name, "path": f"{job}/{name}", "size": SIZE, "sha256": job * 2}


def _events(history: History, moment: Any) -> Iterator[dict[str, Any]]:
    for sweep in range(history.sweeps):
        yield _event("accepted", moment, sweep_id(sweep), None)
        yield _event("published", moment, sweep_id(sweep), _publication_id(sweep))
    for run in range(history.sweeps * history.runs_of_a_sweep):
        for kind in ("started", "succeeded"):
            yield _event(kind, moment, None, run_id(run))


def _event(kind: str, moment: Any, sweep: str | None, job: str | None) -> dict[str, Any]:
    return {"time": moment, "kind": kind, "sweep_id": sweep, "job_id": job, "body": {"attempt": 1}}
