"""Sweeps of an older physics: what they accepted is expanded anew, and what they have already is set aside.

The points of a sweep and their runs are those of one version of the physics. A sweep that has not ended when a newer
one begins to compute gets the points of the newer one, all of them, so that no cube mixes the two. The points that it
had go to another sweep, with the same document, where there is a result among them: it is cancelled, so that cube and
report of these results are made. All of it is one transaction.
"""

import uuid
from datetime import datetime

import sqlalchemy as sa

from service.records.expansion import ExpandedSweep
from service.records.jobs import State
from service.store import transitions
from service.store.connection import Repository
from service.store.events import log_event
from service.store.submission import add_points, insert_publication
from service.store.tables import (
    HAS_RESULT,
    JOBS,
    POINTS,
    PUBLICATIONS,
    SWEEPS,
    StatementRow,
    invalidate_tallies,
    now,
    runs_of,
)
from studies.runs.results import OTHER_PHYSICS

FAILURE = "NotAccepted"
ASIDE = " (results of physics {})"  # behind name and title of a sweep
MOST_OF_NAME = 160  # characters: with what is behind it, less than a document may have

# The run was submitted to another version, which alone gives its numbers: this one refused to compute it.
_OF_OTHER_PHYSICS = sa.and_(JOBS.c.state == State.FAILED, JOBS.c.failure == OTHER_PHYSICS)
_OF_OTHER = (
    sa.select(POINTS)
    .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
    .where(POINTS.c.sweep_id == SWEEPS.c.id, POINTS.c.detached.is_(False), _OF_OTHER_PHYSICS)
    .exists()
)


def _is_outdated(physics: int) -> sa.ColumnElement[bool]:
    """The sweep waits for runs of an older physics, or has runs that this physics refused to compute."""
    waits = (SWEEPS.c.physics < physics) & PUBLICATIONS.c.state.in_([State.WAITING])
    has_refused = (SWEEPS.c.physics <= physics) & PUBLICATIONS.c.state.in_([State.WAITING, State.QUEUED]) & _OF_OTHER
    return SWEEPS.c.cancelled.is_(None) & (waits | has_refused)


class Renewals(Repository):
    """What the leader does with sweeps of an older physics."""

    def outdated(self, physics: int) -> tuple[str, ...]:
        """The unfinished sweeps whose runs are of an older physics than this one, in the order of acceptance."""
        query = sa.select(SWEEPS.c.id).join(PUBLICATIONS, PUBLICATIONS.c.sweep_id == SWEEPS.c.id)
        rows = self._database.rows(query.where(_is_outdated(physics)).order_by(SWEEPS.c.number))
        return tuple(row.id for row in rows)

    def physics_of(self, id: str) -> int:
        """The physics that expanded a sweep."""
        return self._database.value(sa.select(SWEEPS.c.physics).where(SWEEPS.c.id == id))

    def coordinates(self, id: str) -> tuple[tuple[dict[str, float | str], str], ...]:
        """The coordinates of each point of a sweep, with the id of its run."""
        query = sa.select(POINTS.c.coordinates, POINTS.c.run_id).where(POINTS.c.sweep_id == id)
        return tuple((row.coordinates, row.run_id) for row in self._database.rows(query.order_by(POINTS.c.ordinal)))

    def renew(self, id: str, sweep: ExpandedSweep, physics: int) -> bool:
        """Let a sweep that is still outdated wait for these points; False: it has them already, or is not outdated."""
        moment = now()
        with self._database.commanding() as connection:
            row = _outdated_row(connection, id, physics)
            if row is None:
                return False
            # One that searches for a limit may have more.
            first = runs_of(id).order_by(POINTS.c.ordinal).limit(len(sweep.points))
            if list(connection.scalars(first)) == [point.run_id for point in sweep.points]:
                connection.execute(SWEEPS.update().where(SWEEPS.c.id == id).values(physics=physics))
                return False
            older = _set_aside(connection, row, moment)
            transitions.publish_again(connection, id)
            new = add_points(connection, id, sweep.points, moment)
            values = {"document": sweep.document, "digest": sweep.digest, "planned": len(sweep.points), "new": new}
            values |= {"physics": physics, "renewed": moment, "older": older}
            connection.execute(SWEEPS.update().where(SWEEPS.c.id == id).values(values))
            invalidate_tallies(connection, len(sweep.points))
            transitions.release_publications(connection, moment, JOBS.c.sweep_id == id)
            log_event(connection, moment, "renewed", sweep_id=id, physics=physics, older=older)
        return True

    def refuse(self, id: str, reason: str, physics: int) -> bool:
        """Fail a sweep that is still outdated, and whose document this version refuses; its runs leave the queue."""
        moment = now()
        with self._database.commanding() as connection:
            if _outdated_row(connection, id, physics) is None:
                return False
            transitions.refuse(connection, id, moment, failure=FAILURE, reason=reason)
            log_event(connection, moment, State.FAILED, sweep_id=id, reason=reason)
        return True


def _outdated_row(connection: sa.Connection, id: str, physics: int) -> StatementRow | None:
    """The row of a sweep, unless it has ended, was cancelled or was renewed meanwhile."""
    query = sa.select(SWEEPS).join(PUBLICATIONS, PUBLICATIONS.c.sweep_id == SWEEPS.c.id)
    return connection.execute(query.where(SWEEPS.c.id == id, _is_outdated(physics))).first()


def _set_aside(connection: sa.Connection, row: StatementRow, moment: datetime) -> str | None:
    """Take its points from a sweep; return the id of the sweep that has them now, None: there was no result."""
    results = runs_of(row.id).join(JOBS, JOBS.c.id == POINTS.c.run_id)
    results = results.where(POINTS.c.detached.is_(False), HAS_RESULT, sa.not_(_OF_OTHER_PHYSICS))
    if connection.execute(results.limit(1)).first() is None:
        transitions.detach(connection, row.id)
        transitions.cancel(connection, row.id, moment)
        transitions.leave_runs(connection, row.id, moment)
        connection.execute(POINTS.delete().where(POINTS.c.sweep_id == row.id))
        return row.older
    id = uuid.uuid4().hex
    called = {key: row._mapping[key][:MOST_OF_NAME] + ASIDE.format(row.physics) for key in ("name", "title")}
    own = {**row._mapping, **called, "id": id, "document": {**row.document, **called}, "cancelled": moment}
    del own["number"]
    connection.execute(SWEEPS.insert().values(own))
    insert_publication(connection, id, row.owner, moment)
    connection.execute(POINTS.update().where(POINTS.c.sweep_id == row.id).values(sweep_id=id))
    refused = runs_of(id).join(JOBS, JOBS.c.id == POINTS.c.run_id).where(_OF_OTHER_PHYSICS)
    connection.execute(
        POINTS.update().where(POINTS.c.sweep_id == id, POINTS.c.run_id.in_(refused)).values(detached=True)
    )
    transitions.detach(connection, id)
    transitions.cancel(connection, id, moment)
    log_event(connection, moment, "accepted", sweep_id=id, of=row.id)
    return id
