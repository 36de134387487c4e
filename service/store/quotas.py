"""What an owner has under way and keeps, and whether another sweep fits beside it."""

import sqlalchemy as sa

from service.files.disk_space import shown_size
from service.records.expansion import ExpandedSweep
from service.records.jobs import ACTIVE, Kind, QuotaExceeded, Submission
from service.store.tables import ARTIFACTS, JOBS, POINTS, PUBLICATIONS, SWEEPS

WAIT_SECONDS = 60  # until runs have ended
DELETE_SECONDS = 3600  # until somebody has deleted a sweep


def check(connection: sa.Connection, submission: Submission, sweep: ExpandedSweep) -> None:
    """Raise QuotaExceeded if a sweep does not fit beside what its owner has; within the transaction that accepts it."""
    quota, owner = submission.quota, submission.owner
    if quota is None:
        return
    sweeps = sa.select(sa.func.count()).join_from(SWEEPS, PUBLICATIONS, PUBLICATIONS.c.sweep_id == SWEEPS.c.id)
    sweeps = sweeps.where(SWEEPS.c.owner == owner, PUBLICATIONS.c.state.in_(ACTIVE))
    runs = sa.select(sa.func.count()).where(JOBS.c.kind == Kind.RUN, JOBS.c.owner == owner, JOBS.c.state.in_(ACTIVE))
    files = sa.select(sa.func.coalesce(sa.func.sum(ARTIFACTS.c.size), 0))
    files = files.join_from(ARTIFACTS, JOBS, JOBS.c.id == ARTIFACTS.c.job_id).where(JOBS.c.owner == owner)
    # Runs of deleted sweeps stay for a while, and are nobody's.
    files = files.where(JOBS.c.abandoned.is_(None) | sa.exists().where(POINTS.c.run_id == JOBS.c.id))
    has = connection.execute(sa.select(*(each.scalar_subquery() for each in (sweeps, runs, files)))).one()
    text = f"{owner or 'the local user'} has "
    cure = "wait until some have ended, or cancel one"
    if has[0] + 1 > quota.sweeps:
        raise QuotaExceeded(f"{text}{has[0]} sweeps under way, and the quota is {quota.sweeps}; {cure}", WAIT_SECONDS)
    if has[1] + len(sweep.points) > quota.runs:
        more = f"and asks for {len(sweep.points)}; the quota is {quota.runs}"
        raise QuotaExceeded(f"{text}{has[1]} runs under way {more}: {cure}", WAIT_SECONDS)
    if has[2] + sweep.bytes > quota.bytes:
        more = f"and asks for {shown_size(sweep.bytes)}; the quota is {shown_size(quota.bytes)}"
        cure = "delete sweeps, or keep only numbers"
        raise QuotaExceeded(f"{text}{shown_size(has[2])} of files {more}: {cure}", DELETE_SECONDS)
