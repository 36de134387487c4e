"""Results that were read again take the place of those that they were made of."""

from collections.abc import Sequence
from datetime import datetime

import sqlalchemy as sa

from service.jobs import Claim, Kind, State
from service.rereads import Reread, Rereads
from service.store.queries import batches, log_event, release_publications
from service.store.tables import ARTIFACTS, EVENTS, JOBS, POINTS
from studies.files import ANSWER

REMEASURE = {"remeasure": True}  # spec of a publication that first reads states again

_ANSWER: dict[str, sa.BindParameter[object]] = {
    name: sa.bindparam(f"new_{name}") for name in ("path", "size", "sha256")
}
_RUN = (
    JOBS.update()
    .where(JOBS.c.id == sa.bindparam("run"), JOBS.c.sha256 == sa.bindparam("was"))
    .values(**_ANSWER, summary=sa.bindparam("new_summary", type_=JOBS.c.summary.type))
)
_FILE = (
    ARTIFACTS.update()
    .where(ARTIFACTS.c.job_id == sa.bindparam("run"), ARTIFACTS.c.name == ANSWER)
    .where(ARTIFACTS.c.sha256 == sa.bindparam("was"))
    .values(**_ANSWER)
)


def replace_results(
    connection: sa.Connection, moment: datetime, claim: Claim, rereads: Rereads
) -> None:
    """Point rows to new results, where they still have the old ones; sweeps that use them follow."""
    runs = rereads.runs
    if runs:
        connection.execute(_RUN, [_words(one) | {"new_summary": dict(one.summary)} for one in runs])
        connection.execute(_FILE, [_words(one) for one in runs])
        connection.execute(EVENTS.insert(), [_event(moment, one) for one in runs])
        _publish_others(connection, moment, claim, [one.run_id for one in runs])
    counts = {"runs": len(runs), "unreadable": dict(rereads.unreadable or {})}
    log_event(connection, moment, "remeasured", sweep_id=claim.sweep_id, job_id=claim.id, **counts)


def _publish_others(
    connection: sa.Connection, moment: datetime, claim: Claim, run_ids: Sequence[str]
) -> None:
    """Have every other sweep that uses these runs published again.

    One that is being published now was given the old results, unless it reads them again itself.
    """
    using: set[str] = set()
    for batch in batches(run_ids):
        query = sa.select(POINTS.c.sweep_id).where(POINTS.c.run_id.in_(batch)).distinct()
        using |= set(connection.scalars(query))
    for batch in batches(sorted(using - {claim.sweep_id})):
        publication = (JOBS.c.kind == Kind.PUBLISH) & JOBS.c.sweep_id.in_(batch)
        stale = sa.or_(
            JOBS.c.state == State.SUCCEEDED,
            (JOBS.c.state == State.RUNNING) & JOBS.c.spec.is_(None),
        )
        again = JOBS.update().where(publication, stale).returning(JOBS.c.sweep_id)
        for sweep_id in connection.scalars(again.values(state=State.WAITING, crashes=0)).all():
            log_event(connection, moment, "outdated", sweep_id=sweep_id)
        release_publications(connection, moment, publication)


def _words(reread: Reread) -> dict[str, object]:
    answer = reread.answer
    known = {"run": reread.run_id, "was": reread.was}
    return known | {
        "new_path": answer.path,
        "new_size": answer.size,
        "new_sha256": answer.sha256,
    }


def _event(moment: datetime, reread: Reread) -> dict[str, object]:
    body = {"was": reread.was, "sha256": reread.answer.sha256}
    return {
        "time": moment,
        "kind": "remeasured",
        "sweep_id": None,
        "job_id": reread.run_id,
        "body": body,
    }
