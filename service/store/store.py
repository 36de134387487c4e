"""What people ask of the service and order from it."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from service.jobs import (
    ACTIVE,
    SWEEP_TERMINAL,
    TERMINAL,
    Conflict,
    Event,
    Kind,
    NotFound,
    Page,
    PointRow,
    RunRow,
    State,
    Stored,
    SweepRow,
    SweepState,
    before,
)
from service.store import queries
from service.store.connection import Database
from service.store.queries import (
    IS_WANTED,
    POINT_STATE,
    RUN_COLUMNS,
    SWEEP_ROWS,
    SWEEP_STATE,
    log_event,
    now,
    number_of,
    one_row,
    release_publications,
    sweep_row,
)
from service.store.queue import Queue
from service.store.rows import acceptance_of, point_record, run_record, stored_record
from service.store.tables import ARTIFACTS, EVENTS, JOBS, POINTS, SWEEPS

if TYPE_CHECKING:
    from studies.run import Run
    from studies.sweep import Sweep


class Store(Queue):
    """Sweeps, runs, publications, their files and what happened to them."""

    def __init__(self, database: Database, *, cost: Callable[["Run"], float]):
        super().__init__(database)
        self._cost = cost
        self._listeners: list[Callable[[], object]] = []

    @classmethod
    def open(cls, url: str, *, cost: Callable[["Run"], float] | None = None) -> "Store":
        """Connect, bring the tables up to date, and return the store.

        ``cost`` estimates the core seconds of a run; without it ``studies.run.estimate`` does.
        """
        database = Database(url)
        database.migrate()
        return cls(database, cost=cost or _estimated_core_seconds)

    def close(self) -> None:
        """Give every connection back."""
        self._database.close()

    def on_order(self, listener: Callable[[], object]) -> None:
        """Call ``listener`` after each order given here; it is told nothing and must be quick."""
        self._listeners.append(listener)

    def ping(self) -> None:
        """Ask for the right to write, and write nothing; raises StoreUnavailable."""
        with self._database.writing() as connection:
            connection.execute(sa.select(sa.literal(1)))

    @contextmanager
    def _ordering(self) -> Iterator[sa.Connection]:
        """A transaction that gives the dispatcher something to do."""
        with self._database.writing() as connection:
            yield connection
        for listener in self._listeners:
            listener()

    # --- orders ----------------------------------------------------------------------------------

    def create_sweep(self, sweep: "Sweep") -> SweepRow:
        """Accept a sweep: its row, runs, points and publication, or nothing at all.

        A run that is finished is linked, one that is under way is joined, one that an accident or a
        cancel ended is queued again.
        """
        moment = now()
        rows = acceptance_of(sweep, cost=self._cost, moment=moment)
        id, planned = rows.sweep["id"], rows.sweep["planned"]
        with self._ordering() as connection:
            inserted = queries.insert_missing(connection, rows.jobs)
            connection.execute(SWEEPS.insert(), [rows.sweep])
            connection.execute(POINTS.insert(), rows.points)
            again = queries.queue_again(connection, id, moment, verdicts=False)
            new = len(inserted | again)
            connection.execute(SWEEPS.update().where(SWEEPS.c.id == id).values(new=new))
            connection.execute(JOBS.insert(), [rows.publication])
            release_publications(connection, moment, JOBS.c.sweep_id == id)
            log_event(connection, moment, "accepted", sweep_id=id, planned=planned, new=new)
            return sweep_row(connection, id)

    def cancel_sweep(self, id: str) -> SweepRow:
        """Stop waiting for the runs that are not done; a run that nobody waits for is stopped.

        What was computed until then is published. Cancelling a sweep that no longer waits for a run
        changes nothing.
        """
        moment = now()
        own = sa.select(POINTS.c.run_id).where(POINTS.c.sweep_id == id)
        unfinished = sa.select(JOBS.c.id).where(JOBS.c.id.in_(own), JOBS.c.state.in_(ACTIVE))
        waits = sa.exists().where(JOBS.c.sweep_id == id, JOBS.c.state == State.WAITING)
        detach = POINTS.update().where(
            *(POINTS.c.sweep_id == id, POINTS.c.detached.is_(False)),
            *(POINTS.c.run_id.in_(unfinished), waits),
        )
        unwanted = JOBS.update().where(JOBS.c.id.in_(own), sa.not_(IS_WANTED))
        with self._ordering() as connection:
            detached = connection.execute(detach.values(detached=True)).rowcount
            if detached:
                cancelled = {"state": State.CANCELLED, "finished": moment}
                cancel = SWEEPS.update().where(SWEEPS.c.id == id).values(cancelled=moment)
                drop = unwanted.where(JOBS.c.state == State.QUEUED).values(cancelled)
                stop = unwanted.where(JOBS.c.state == State.RUNNING)
                connection.execute(cancel)
                connection.execute(drop)
                connection.execute(stop.values(state=State.CANCELLING))
                queries.settle_cancelled_publication(connection, id, moment)
                log_event(connection, moment, "cancelled", sweep_id=id, points=detached)
            return sweep_row(connection, id)

    def retry_sweep(self, id: str, *, verdicts: bool = False) -> SweepRow:
        """Queue again what an accident or a cancel ended (on request: verdicts), then publish."""
        moment = now()
        publication = sa.select(JOBS.c.state).where(JOBS.c.sweep_id == id)
        fresh = dict.fromkeys(("cause", "failure", "reason", "finished"), sa.null())
        revive = SWEEPS.update().where(SWEEPS.c.id == id).values(cancelled=sa.null())
        attach = POINTS.update().where(POINTS.c.sweep_id == id).values(detached=False)
        with self._ordering() as connection:
            if one_row(connection, publication, "sweep", id).state is State.RUNNING:
                raise Conflict("the sweep is being published; retry it when that is done")
            connection.execute(revive)
            connection.execute(attach)
            again = queries.queue_again(connection, id, moment, verdicts=verdicts)
            connection.execute(
                JOBS.update()
                .where(JOBS.c.sweep_id == id, JOBS.c.state.in_(before(State.WAITING)))
                .values(state=State.WAITING, crashes=0, **fresh)
            )
            release_publications(connection, moment, JOBS.c.sweep_id == id)
            log_event(connection, moment, "retried", sweep_id=id, runs=len(again))
            return sweep_row(connection, id)

    def delete_sweep(self, id: str) -> None:
        """Forget a sweep that has ended; its runs stay, because other sweeps may ask for them."""
        with self._ordering() as connection:
            state = sweep_row(connection, id).state
            if state not in SWEEP_TERMINAL:
                raise Conflict(f"the sweep is {state}; cancel it, then delete it")
            for table in (ARTIFACTS, POINTS, JOBS):
                connection.execute(table.delete().where(table.c.sweep_id == id))
            connection.execute(SWEEPS.delete().where(SWEEPS.c.id == id))
            log_event(connection, now(), "deleted", sweep_id=id)

    # --- questions -------------------------------------------------------------------------------

    def sweep(self, id: str) -> SweepRow:
        """One sweep; raises NotFound."""
        with self._database.reading() as connection:
            return sweep_row(connection, id)

    def sweeps(
        self, *, state: SweepState | None = None, cursor: str | None = None, limit: int = 50
    ) -> Page[SweepRow]:
        """Sweeps, the youngest first: two statements, whatever the number of runs."""
        query = SWEEP_ROWS.order_by(SWEEPS.c.number.desc()).limit(limit + 1)
        if state is not None:
            query = query.where(SWEEP_STATE.in_([state]))
        if cursor is not None:
            query = query.where(SWEEPS.c.number < number_of(cursor))
        with self._database.reading() as connection:
            rows = connection.execute(query).all()
            items = queries.sweep_rows(connection, rows[:limit])
        return Page(items, str(rows[limit - 1].number) if len(rows) > limit else None)

    def sweep_document(self, id: str) -> Mapping[str, Any]:
        """The document of a sweep, canonical; raises NotFound."""
        query = sa.select(SWEEPS.c.document).where(SWEEPS.c.id == id)
        with self._database.reading() as connection:
            return one_row(connection, query, "sweep", id).document

    def find_sweep(self, digest: str) -> SweepRow | None:
        """The youngest sweep with this ``digest_of``: the same question, asked before."""
        query = SWEEP_ROWS.where(SWEEPS.c.digest == digest).order_by(SWEEPS.c.number.desc())
        with self._database.reading() as connection:
            rows = connection.execute(query.limit(1)).all()
            return queries.sweep_rows(connection, rows)[0] if rows else None

    def counts(self, sweep_id: str) -> Mapping[str, int]:
        """Points of a sweep per state; raises NotFound."""
        return self.sweep(sweep_id).counts

    def sweep_runs(
        self, id: str, *, state: State | None = None, cursor: str | None = None, limit: int = 100
    ) -> Page[PointRow]:
        """Points of a sweep in its own order, each with its run; raises NotFound."""
        query = (
            sa.select(*RUN_COLUMNS, POINTS, POINT_STATE.label("point_state"))
            .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
            .where(POINTS.c.sweep_id == id)
            .order_by(POINTS.c.ordinal)
            .limit(limit + 1)
        )
        if state is not None:
            query = query.where(POINT_STATE.in_([state]))
        if cursor is not None:
            query = query.where(POINTS.c.ordinal > number_of(cursor))
        with self._database.reading() as connection:
            one_row(connection, sa.select(SWEEPS.c.id).where(SWEEPS.c.id == id), "sweep", id)
            rows = connection.execute(query).all()
        items = tuple(point_record(row) for row in rows[:limit])
        return Page(items, str(items[-1].ordinal) if len(rows) > limit else None)

    def run(self, id: str) -> RunRow:
        """One run; raises NotFound."""
        query = sa.select(*RUN_COLUMNS).where(JOBS.c.id == id, JOBS.c.kind == Kind.RUN)
        with self._database.reading() as connection:
            return run_record(one_row(connection, query, "run", id))

    def run_spec(self, id: str) -> Mapping[str, Any]:
        """The question of a run, complete (``Run.as_json``); raises NotFound."""
        query = sa.select(JOBS.c.spec).where(JOBS.c.id == id, JOBS.c.kind == Kind.RUN)
        with self._database.reading() as connection:
            return one_row(connection, query, "run", id).spec

    def artifact(self, sweep_id: str, name: str) -> Stored:
        """A file of a sweep; raises NotFound, also when it is not published yet."""
        for file in self.artifacts(sweep_id):
            if file.name == name:
                return file
        raise NotFound("file", f"{sweep_id}/{name}")

    def artifacts(self, sweep_id: str) -> tuple[Stored, ...]:
        """The published files of a sweep; none before its publication."""
        query = sa.select(ARTIFACTS).where(ARTIFACTS.c.sweep_id == sweep_id)
        with self._database.reading() as connection:
            rows = connection.execute(query.order_by(ARTIFACTS.c.name))
            return tuple(stored_record(row) for row in rows)

    def events(self, sweep_id: str, *, after: int = 0, limit: int = 1000) -> tuple[Event, ...]:
        """What happened to a sweep and its runs since it was accepted, oldest first."""
        of_sweep = EVENTS.c.sweep_id == sweep_id
        first = sa.select(sa.func.min(EVENTS.c.number)).where(of_sweep).scalar_subquery()
        own = sa.select(POINTS.c.run_id).where(POINTS.c.sweep_id == sweep_id)
        query = (
            sa.select(EVENTS)
            .where(EVENTS.c.number > after, EVENTS.c.number >= first)
            .where(sa.or_(of_sweep, EVENTS.c.job_id.in_(own)))
            .order_by(EVENTS.c.number)
            .limit(limit)
        )
        with self._database.reading() as connection:
            return tuple(Event(**row._mapping) for row in connection.execute(query))

    def states(self) -> Mapping[State, int]:
        """Jobs per state in the whole store."""
        query = sa.select(JOBS.c.state, sa.func.count().label("jobs")).group_by(JOBS.c.state)
        with self._database.reading() as connection:
            return {row.state: row.jobs for row in connection.execute(query)}

    def pace(self) -> float | None:
        """Measured seconds for each estimated core second, over all results; None if none."""
        query = sa.select(sa.func.sum(JOBS.c.seconds), sa.func.sum(JOBS.c.cost)).where(
            JOBS.c.kind == Kind.RUN, JOBS.c.state.in_(TERMINAL), JOBS.c.path.is_not(None)
        )
        with self._database.reading() as connection:
            seconds, cost = connection.execute(query).one()
        return seconds / cost if cost else None

    def known_runs(self, ids: Iterable[str]) -> set[str]:
        """Which of these runs are finished or under way, so that asking computes nothing new."""
        known = sa.not_(queries.ended_by_accident(verdicts=False))
        found = sa.select(JOBS.c.id).where(known)
        with self._database.reading() as connection:
            return {
                id
                for batch in queries.batches(ids)
                for id in connection.scalars(found.where(JOBS.c.id.in_(batch)))
            }


def _estimated_core_seconds(run: "Run") -> float:
    """What the studies expect a run to cost."""
    from studies.run import estimate

    return estimate(run).core_seconds
