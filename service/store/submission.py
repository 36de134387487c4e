"""Accepted sweeps become rows: the sweep, its publication, its points, and those runs that no sweep has brought yet."""

import uuid
from collections.abc import Sequence
from datetime import datetime
from typing import TYPE_CHECKING

import sqlalchemy as sa

from service.records.expansion import ExpandedPoint, ExpandedSweep, expand
from service.records.jobs import Keep, KeyReused, Kind, QuotaExceeded, State, Submission
from service.store import fair_queueing, transitions
from service.store.connection import JsonText
from service.store.tables import (
    IDEMPOTENCY,
    IS_ACTIVE,
    JOBS,
    POINTS,
    PUBLISH_PRIORITY,
    SWEEPS,
    batches,
    count,
    insert_into,
    literal,
    runs_of,
)
from solver import PHYSICS_VERSION

if TYPE_CHECKING:
    from studies.sweeps.sweep import Sweep

WAIT_SECONDS = 60  # until runs have ended
DELETE_SECONDS = 3600  # until somebody has deleted a sweep
BATCH = 1000  # rows inserted by one statement; the specification of a run takes 3 kB
UNBEGUN = {"attempt": 0, "term": 0, "crashes": 0, "bytes": 0}  # columns of a job


def digest_of(sweep: "Sweep") -> str:
    """Digest of a sweep's document and of its runs: the same document for the same physics."""
    return expand(sweep, cost=lambda _run: 0.0).digest


def accepted_before(connection: sa.Connection, submission: Submission) -> str | None:
    """Id of the sweep of an earlier submission with this idempotency key; raises KeyReused."""
    if submission.idempotency is None:
        return None
    key, digest = submission.idempotency
    query = sa.select(IDEMPOTENCY.c.digest, IDEMPOTENCY.c.sweep_id).where(
        IDEMPOTENCY.c.owner == submission.owner, IDEMPOTENCY.c.key == key
    )
    row = connection.execute(query).first()
    if row is None:
        return None
    if row.digest != digest:
        raise KeyReused(f"the key {key!r} was used for another body; take a new one")
    return str(row.sweep_id)


def check_quota(connection: sa.Connection, submission: Submission, sweep: ExpandedSweep) -> None:
    """Raise QuotaExceeded if a sweep does not fit beside what its owner has; within the transaction that accepts it."""
    quota, owner = submission.quota, submission.owner
    if quota is None:
        return
    under_way = sa.select(sa.func.count()).where(IS_ACTIVE, JOBS.c.owner == owner)
    sweeps, runs = (under_way.where(JOBS.c.kind == literal(kind)) for kind in (Kind.PUBLISH, Kind.RUN))
    files = sa.select(sa.func.sum(JOBS.c.bytes)).where(JOBS.c.owner == owner, JOBS.c.abandoned.is_(None))
    counts = sa.select(*(query.scalar_subquery() for query in (sweeps, runs, files)))
    has = [int(number or 0) for number in connection.execute(counts).one()]
    text = f"{owner} has "
    cure = "wait until some have ended, or cancel one"
    if has[0] + 1 > quota.sweeps:
        raise QuotaExceeded(f"{text}{has[0]} sweeps under way, and the quota is {quota.sweeps}; {cure}", WAIT_SECONDS)
    asked = [point.run_id for point in sweep.points if point.parameters is not None]
    new = len(asked)
    if has[1] + new > quota.runs:  # most sweeps are far from it, and nothing is looked up for them
        is_there = sa.not_(transitions.may_be_retried(submission.keep))
        new -= sum(count(connection, is_there, JOBS.c.id.in_(batch)) for batch in batches(asked))
    if has[1] + new > quota.runs:
        more = f"and asks for {new}; the quota is {quota.runs}"
        raise QuotaExceeded(f"{text}{has[1]} runs under way {more}: {cure}", WAIT_SECONDS)
    if has[2] + sweep.bytes > quota.bytes:
        more = f"and asks for {sweep.bytes / 1e9:.3g} GB; the quota is {quota.bytes / 1e9:.3g} GB"
        cure = "delete sweeps, or keep only numbers"
        raise QuotaExceeded(f"{text}{has[2] / 1e9:.3g} GB of files {more}: {cure}", DELETE_SECONDS)


def accept(connection: sa.Connection, submission: Submission, sweep: ExpandedSweep, moment: datetime) -> str:
    """Write the rows of a sweep, and join it to runs that are there already; return its id."""
    id = uuid.uuid4().hex
    connection.execute(
        SWEEPS.insert().values(
            id=id,
            name=sweep.name,
            title=sweep.title,
            scenario=sweep.scenario,
            document=sweep.document,
            digest=sweep.digest,
            owner=submission.owner,
            priority=submission.priority,
            keep=submission.keep,
            planned=len(sweep.points),
            new=0,
            created=moment,
            physics=PHYSICS_VERSION,
        )
    )
    insert_publication(connection, id, submission.owner, moment)
    new = add_points(connection, id, sweep.points, moment)
    connection.execute(SWEEPS.update().where(SWEEPS.c.id == id).values(new=new))
    transitions.release_publications(connection, moment, JOBS.c.sweep_id == id)
    if submission.idempotency is not None:
        key, digest = submission.idempotency
        row = {"owner": submission.owner, "key": key, "digest": digest, "sweep_id": id}
        connection.execute(IDEMPOTENCY.insert().values(row))
    return id


def insert_publication(connection: sa.Connection, sweep_id: str, owner: str, moment: datetime) -> None:
    """Add the publication of a sweep, which waits for its runs."""
    connection.execute(
        JOBS.insert().values(
            id=uuid.uuid4().hex,
            kind=Kind.PUBLISH,
            sweep_id=sweep_id,
            state=State.WAITING,
            priority=PUBLISH_PRIORITY,
            owner=owner,
            virtual_time=0.0,
            ordinal=0,
            keep=Keep.NUMBERS,
            cost=1.0,
            **UNBEGUN,
            created=moment,
            queued=moment,
        )
    )


def add_points(
    connection: sa.Connection, sweep_id: str, points: Sequence[ExpandedPoint], moment: datetime, first: int = 0
) -> int:
    """Add points to a sweep, from the ordinal ``first`` on; return the number of runs that it brought into the queue.

    A run that is finished is linked, one that is under way is joined, one that an accident or a cancel ended is queued
    again.
    """
    query = sa.select(SWEEPS.c.priority, SWEEPS.c.owner, SWEEPS.c.keep).where(SWEEPS.c.id == sweep_id)
    sweep = connection.execute(query).one()
    new_points = [(ordinal, point) for ordinal, point in enumerate(points, first) if point.parameters is not None]
    same = {**sweep._mapping, **UNBEGUN, "kind": Kind.RUN, "state": State.QUEUED, "created": moment, "queued": moment}
    insert = insert_into(connection, JOBS).on_conflict_do_nothing().execution_options(preserve_rowcount=True)
    new, virtual_time = 0, fair_queueing.open_queue(connection, sweep.priority, sweep.owner)
    for batch in batches(new_points, BATCH):
        rows = []
        for ordinal, point in batch:
            own = {"id": point.run_id, "scenario": point.scenario, "spec": JsonText(point.spec), "cost": point.cost}
            rows.append({**same, **own, "ordinal": ordinal, "virtual_time": virtual_time})
            virtual_time += point.cost
        new += connection.execute(insert, rows).rowcount
    for numbered in batches(enumerate(points, first), BATCH):
        rows = [
            {
                "sweep_id": sweep_id,
                "ordinal": ordinal,
                "run_id": point.run_id,
                "axis_index": JsonText(point.axis_index),
                "coordinates": JsonText(point.coordinates),
                "detached": False,
            }
            for ordinal, point in numbered
        ]
        connection.execute(POINTS.insert(), rows)
    if new < len(new_points):
        among = [point.run_id for _, point in new_points] if first else None
        new += transitions.retry(connection, sweep_id, moment, verdicts=False, among=among)
        fair_queueing.schedule(connection, sweep_id)
        abandoned = JOBS.update().where(JOBS.c.id.in_(runs_of(sweep_id)), JOBS.c.abandoned.is_not(None))
        connection.execute(abandoned.values(abandoned=None, owner=sweep.owner))
    return new
