"""Rows turned into records, and what is accepted turned into rows."""

import hashlib
import json
import uuid
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from service.records.jobs import (
    ACTIVE,
    RUN_STATES,
    Claim,
    Keep,
    KeyRow,
    Kind,
    MeasuredRun,
    PointRow,
    RunRow,
    Scope,
    State,
    Stored,
    Submission,
    SweepRow,
)
from service.store.tables import JOBS, POINTS

if TYPE_CHECKING:
    from studies.runs.run import Run
    from studies.sweeps.sweep import Point, Sweep

Row = sa.Row[*tuple[Any, ...]]  # a row of whatever columns

PUBLISH_PRIORITY = -1000  # a finished sweep is published before more runs begin


@dataclass(frozen=True)
class Acceptance:
    """Everything that accepting a sweep writes."""

    sweep: dict[str, Any]
    jobs: list[dict[str, Any]]  # its runs, each once
    points: list[dict[str, Any]]
    publication: dict[str, Any]


def acceptance_of(
    asked: Submission, *, cost: Callable[["Run"], float], moment: datetime
) -> Acceptance:
    """The rows of a sweep that is accepted now; ``cost`` gives core seconds.

    The turns of its runs are those in an empty queue, if all of them are new.
    """
    id, sweep = uuid.uuid4().hex, asked.sweep
    points, document = sweep.runs(), sweep.document()
    run_ids = [point.run.id for point in points]  # each is a digest: ask once
    jobs: dict[str, dict[str, Any]] = {}
    turn = 0.0
    common = {"priority": asked.priority, "keep": asked.keep, "created": moment, "queued": moment}
    for ordinal, (run_id, point) in enumerate(zip(run_ids, points, strict=True)):
        if run_id not in jobs:
            seconds = cost(point.run)
            place = {"ordinal": ordinal, "turn": turn, "cost": seconds}
            jobs[run_id] = _run(run_id, point.run) | place | common
            turn += seconds
    row = {
        "id": id,
        "name": sweep.name,
        "title": sweep.title or sweep.name,
        "scenario": sweep.scenario,
        "document": document,
        "digest": _digest(document, run_ids),
        "owner": asked.owner,
        "priority": asked.priority,
        "keep": asked.keep,
        "planned": len(points),
        "new": 0,
        "created": moment,
    }
    links = [
        _point(id, ordinal, run_id, point)
        for ordinal, (run_id, point) in enumerate(zip(run_ids, points, strict=True))
    ]
    return Acceptance(row, [*jobs.values()], links, _publication(id, moment))


def digest_of(sweep: "Sweep") -> str:
    """Digest of a sweep's document and of its runs: the same question to the same physics."""
    return _digest(sweep.document(), [point.run.id for point in sweep.runs()])


def _digest(document: Mapping[str, Any], run_ids: Sequence[str]) -> str:
    question = json.dumps([document, run_ids], sort_keys=True)
    return hashlib.sha256(question.encode()).hexdigest()


def _run(id: str, run: "Run") -> dict[str, Any]:
    """Row of a run that nobody has asked for yet, without its place in the queue."""
    return {
        "id": id,
        "kind": Kind.RUN,
        "scenario": run.scenario,
        "spec": run.as_json(),
        "state": State.QUEUED,
        "attempt": 0,
        "epoch": 0,
        "crashes": 0,
    }


def _publication(sweep_id: str, moment: datetime) -> dict[str, Any]:
    """Row of the publication of a new sweep."""
    return {
        "id": uuid.uuid4().hex,
        "kind": Kind.PUBLISH,
        "sweep_id": sweep_id,
        "state": State.WAITING,
        "priority": PUBLISH_PRIORITY,
        "turn": 0.0,
        "ordinal": 0,
        "keep": Keep.NUMBERS,
        "cost": 1.0,
        "attempt": 0,
        "epoch": 0,
        "crashes": 0,
        "created": moment,
        "queued": moment,
    }


def _point(sweep_id: str, ordinal: int, run_id: str, point: "Point") -> dict[str, Any]:
    """Row of a point of a sweep."""
    return {
        "sweep_id": sweep_id,
        "ordinal": ordinal,
        "run_id": run_id,
        "place": list(point.index),
        "coordinates": dict(point.coordinates),
        "detached": False,
    }


def sweep_record(row: Row, tallies: Sequence[Row]) -> SweepRow:
    """A sweep from its row and from its tallies: points, cost, done and seconds per state."""
    counts = dict.fromkeys((state.value for state in RUN_STATES), 0)
    counts |= {tally.point_state.value: tally.points for tally in tallies}
    active = [tally for tally in tallies if tally.point_state in ACTIVE]
    remaining = sum(tally.cost - tally.done for tally in active)
    computed = sum(map(_computed, tallies))
    total = sum(tally.cost for tally in tallies)
    done = sum(tally.done for tally in tallies)
    pace = sum(tally.seconds or 0.0 for tally in tallies) / done if done else None
    return SweepRow(
        id=row.id,
        name=row.name,
        title=row.title,
        scenario=row.scenario,
        owner=row.owner,
        priority=row.priority,
        keep=row.keep,
        state=row.state,
        reason=row.reason,
        planned=row.planned,
        reused=row.planned - row.new,
        new=row.new,
        counts=counts,
        progress=computed / total if total else 1.0,
        eta_seconds=_eta(remaining, pace, side_by_side=counts[State.RUNNING]),
        created=row.created,
        cancelled=row.cancelled,
        finished=row.finished,
    )


def _computed(tally: Row) -> float:
    """Cost of what is computed of the points in a state: nothing of those that were cancelled."""
    if tally.point_state is State.CANCELLED:
        return 0.0
    return tally.done if tally.point_state in ACTIVE else tally.cost


def _eta(remaining: float, pace: float | None, *, side_by_side: int) -> float | None:
    """Seconds to go for ``remaining`` estimated core seconds, each taking ``pace`` seconds."""
    if not remaining:
        return 0.0
    return None if pace is None else remaining * pace / max(1, side_by_side)


def claim_record(row: Row) -> Claim:
    """A claim from a row that has CLAIM_COLUMNS."""
    known = {field: row._mapping[JOBS.c[field]] for field in Claim.__dataclass_fields__}
    return Claim(**{**known, "spec": known["spec"] or {}})


def run_record(row: Row) -> RunRow:
    """A run from a row that has RUN_COLUMNS."""
    return RunRow(**{field: row._mapping[JOBS.c[field]] for field in RunRow.__dataclass_fields__})


def point_record(row: Row) -> PointRow:
    """A point from a row that has the columns of POINTS, RUN_COLUMNS and ``point_state``."""
    return PointRow(
        ordinal=row._mapping[POINTS.c.ordinal],
        index=tuple(row.place),
        coordinates=row.coordinates,
        state=row.point_state,
        run=run_record(row),
    )


def stored_record(row: Row) -> Stored:
    """A file from a row of ARTIFACTS."""
    return Stored(name=row.name, path=row.path, size=row.size, sha256=row.sha256)


def measured_record(row: Row) -> MeasuredRun:
    """A run with its final state, from the columns of both."""
    kept = None if row.path is None else stored_record(row)
    return MeasuredRun(row.run_id, row.scenario, row.state, row.summary, kept)


def key_record(row: Row) -> KeyRow:
    """An API key from a row of KEYS."""
    known = {name: getattr(row, name) for name in KeyRow.__dataclass_fields__ if name != "scopes"}
    return KeyRow(**known, scopes=frozenset(Scope(word) for word in row.scopes.split()))
