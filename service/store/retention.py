"""Queries and statements of garbage collection: which sweeps, runs and files still count, and which were read last."""

import sys
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import datetime

import sqlalchemy as sa

from service.records.clock import ClockHistory, read_clocks
from service.records.jobs import KEPT_BY, TERMINAL, ExpiredSweep, Keep, Kind, LastAttempt, Scrub, Stored, at_least
from service.store.connection import Repository
from service.store.events import log_event
from service.store.tables import (
    ARTIFACTS,
    CONTROL,
    EVENTS,
    HAS_ENDED,
    JOBS,
    POINTS,
    SWEEPS,
    Query,
    batches,
    count_bytes,
    now,
    stored_record,
)

STAYS = sys.maxsize  # in place of the number of a sweep
AFTER_HEX = "g"  # added to the beginning of an id, it comes after every id that begins so
BY_JOB = [ARTIFACTS.c.job_id, ARTIFACTS.c.name]


class Retention(Repository):
    """Files that no sweep keeps, runs that no sweep has, and what the store knows of folders on the disk."""

    def discardable(self, limit: int, shard: str) -> tuple[tuple[str, Stored], ...]:
        """Registered files that no sweep keeps, each with its run; ``drop`` removes them from the rows.

        ``shard``: only of runs whose ids begin so, because a search of all of them takes long.
        """
        in_shard = ARTIFACTS.c.job_id.between(shard, shard + AFTER_HEX)
        return self._files(sa.select(ARTIFACTS).where(in_shard, _IS_DROPPED).limit(limit))

    def drop(self, files: Iterable[tuple[str, Stored]]) -> tuple[tuple[str, Stored], ...]:
        """Unregister those of these files that no sweep keeps now; return them, so that they are deleted."""
        dropped = []
        with self._database.writing() as connection:
            for job_id, file in files:
                here = (ARTIFACTS.c.job_id == job_id) & (ARTIFACTS.c.name == file.name)
                if connection.execute(ARTIFACTS.delete().where(here, _IS_DROPPED)).rowcount:
                    connection.execute(_keep_less(job_id, file.name))
                    count_bytes(connection, JOBS.c.id == job_id)
                    dropped.append((job_id, file))
        return tuple(dropped)

    def forget_files(self, job_id: str, names: Iterable[str]) -> None:
        """Unregister files of a job that are missing on the disk."""
        gone = ARTIFACTS.delete().where(ARTIFACTS.c.job_id == job_id)
        with self._database.writing() as connection:
            for name in names:
                connection.execute(gone.where(ARTIFACTS.c.name == name))
                if name in KEPT_BY:
                    connection.execute(_keep_less(job_id, name))
            count_bytes(connection, JOBS.c.id == job_id)

    def forget_runs(self, before: datetime, limit: int) -> int:
        """Forget ended runs whose last sweep was deleted before a moment; return their number.

        Their folders stay until the disk is swept: see ``forgotten_runs``.
        """
        abandoned = sa.select(JOBS.c.id).where(JOBS.c.abandoned < before, HAS_ENDED)
        # In the order of their index, which is read then, whatever the server knows of its tables.
        candidates = [row.id for row in self._database.rows(abandoned.order_by(JOBS.c.abandoned).limit(limit))]
        if not candidates:
            return 0
        moment = now()
        unused = abandoned.where(sa.not_(sa.exists().where(POINTS.c.run_id == JOBS.c.id)))
        with self._database.writing() as connection:
            gone = connection.scalars(unused.where(JOBS.c.id.in_(candidates))).all()
            connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id.in_(gone)))
            connection.execute(JOBS.delete().where(JOBS.c.id.in_(gone)))
            for id in gone:
                log_event(connection, moment, "forgotten", job_id=id)
        return len(gone)

    def expired(self, before: datetime, *, owner: str | None = None, to_size: int = -1) -> Mapping[str, ExpiredSweep]:
        """Sweeps that ended before a moment and are not pinned, by id, in the order of acceptance.

        With ``to_size`` only so many that the files of all sweeps have at most as many bytes. The files of a run go
        with the last sweep that has it: with none of these, if another one has it too.
        """
        ended = HAS_ENDED & (JOBS.c.finished < before) & JOBS.c.sweep_id.is_not(None) & SWEEPS.c.pinned.is_(None)
        due = sa.select(*(SWEEPS.c[name] for name in ("number", "id", "name", "owner")), JOBS.c.finished)
        due = due.join_from(JOBS, SWEEPS, SWEEPS.c.id == JOBS.c.sweep_id)
        due = due.where(ended, sa.true() if owner is None else SWEEPS.c.owner == owner)
        with self._database.reading() as connection:
            rows = connection.execute(due.order_by(SWEEPS.c.number)).all()
            size_of = _sizes(connection, due.subquery()) if rows else {}
        left = sum(size_of.values())
        expired: dict[str, ExpiredSweep] = {}
        for row in rows:
            if left <= to_size:
                break
            size = size_of.get(row.id, 0)
            expired[row.id] = ExpiredSweep(row.id, row.name, row.owner, row.finished, size)
            left -= size
        return expired

    def sweeps(self) -> int:
        """Number of sweeps."""
        return self._database.value(sa.select(sa.func.count()).select_from(SWEEPS))

    def runs(self) -> int:
        """Number of runs."""
        return self._database.value(sa.select(sa.func.count()).where(JOBS.c.kind == Kind.RUN))

    def clock_history(self) -> ClockHistory | None:
        """What was seen of the wall clock; None: nothing yet."""
        with self._database.reading() as connection:
            return _clock_history(connection)

    def note_clock_history(self, change: Callable[[ClockHistory | None], ClockHistory]) -> ClockHistory:
        """Replace what was seen of the wall clock by what ``change`` makes of it; return that."""
        with self._database.writing() as connection:
            history = change(_clock_history(connection))
            connection.execute(CONTROL.update().values(clock=history.as_json()))
        return history

    def trust_clock(self) -> None:
        """Believe the wall clock from now on, whatever it did."""
        now = read_clocks()
        self.note_clock_history(lambda history: (history or ClockHistory(now)).seen(now).trusted())

    def scrub(self) -> Scrub:
        """How far the comparison of all files with their digests is."""
        return Scrub(**self._database.value(sa.select(CONTROL.c.scrub)) or {})

    def note_scrub(self, scrub: Scrub) -> None:
        with self._database.writing() as connection:
            connection.execute(CONTROL.update().values(scrub=vars(scrub)))

    def files(self, *, after: tuple[str, str] = ("", ""), limit: int = 1000) -> tuple[tuple[str, Stored], ...]:
        """Every registered file, by job and name; ``after`` is the last one of the page before."""
        query = sa.select(ARTIFACTS).where(sa.tuple_(*BY_JOB) > sa.tuple_(*after))
        return self._files(query.limit(limit))

    def files_between(self, first: str, last: str) -> tuple[tuple[str, Stored], ...]:
        """The registered files of the jobs between two ids, both included."""
        return self._files(sa.select(ARTIFACTS).where(ARTIFACTS.c.job_id.between(first, last)))

    def last_attempts(self, job_ids: Iterable[str]) -> Mapping[str, LastAttempt]:
        """The last attempt of each of these jobs; unknown jobs are left out."""
        query = sa.select(JOBS.c.id, JOBS.c.attempt, JOBS.c.token, JOBS.c.state)
        with self._database.reading() as connection:
            return {
                row.id: LastAttempt(row.attempt, row.token, row.state)
                for batch in batches(job_ids)
                for row in connection.execute(query.where(JOBS.c.id.in_(batch)))
            }

    def deleted_sweeps(self, sweep_ids: Sequence[str]) -> set[str]:
        """Those of these sweeps that were in this store and were deleted."""
        return self._named_in("deleted", EVENTS.c.sweep_id, sweep_ids)

    def forgotten_runs(self, ids: Sequence[str]) -> set[str]:
        """Those of these runs that ``forget_runs`` removed; a later sweep may have brought them again."""
        return self._named_in("forgotten", EVENTS.c.job_id, ids)

    def _named_in(self, kind: str, column: sa.Column[str], ids: Sequence[str]) -> set[str]:
        """Those of these ids that a column of the events of one kind holds."""
        query = sa.select(column).where(EVENTS.c.kind == kind)
        with self._database.reading() as connection:
            return {id for batch in batches(ids) for id in connection.scalars(query.where(column.in_(batch)))}

    def _files(self, query: Query) -> tuple[tuple[str, Stored], ...]:
        return tuple((row.job_id, stored_record(row)) for row in self._database.rows(query.order_by(*BY_JOB)))


def _sizes(connection: sa.Connection, going: sa.Subquery) -> Counter[str | None]:
    """The bytes of all files by sweep: a run that several sweeps have is that of the last of those that are ``going``.

    None in place of a sweep that stays, where it shares its run. Most runs have one sweep, and sorting all would take
    as long as reading their files.
    """
    shared = sa.select(POINTS.c.run_id).group_by(POINTS.c.run_id).having(sa.func.count() > 1)
    size = sa.func.sum(ARTIFACTS.c.size)
    of_jobs = sa.select(JOBS.c.sweep_id, size).join_from(JOBS, ARTIFACTS, ARTIFACTS.c.job_id == JOBS.c.id)
    of_runs = sa.select(POINTS.c.sweep_id, size).join_from(POINTS, ARTIFACTS, ARTIFACTS.c.job_id == POINTS.c.run_id)
    last = sa.func.max(sa.func.coalesce(going.c.number, STAYS)).label("last")
    runs = sa.select(POINTS.c.run_id, last).join_from(POINTS, going, going.c.id == POINTS.c.sweep_id, isouter=True)
    lasts = runs.where(POINTS.c.run_id.in_(shared)).group_by(POINTS.c.run_id).subquery()
    of_shared = sa.select(going.c.id, size).join_from(lasts, ARTIFACTS, ARTIFACTS.c.job_id == lasts.c.run_id)
    of_shared = of_shared.join(going, going.c.number == lasts.c.last, isouter=True)
    sizes = Counter[str | None]()
    for sums in (
        of_jobs.where(JOBS.c.sweep_id.is_not(None)).group_by(JOBS.c.sweep_id),
        of_runs.where(POINTS.c.run_id.not_in(shared)).group_by(POINTS.c.sweep_id),
        of_shared.group_by(going.c.id),
    ):
        for sweep, bytes in connection.execute(sums):
            sizes[sweep] += int(bytes)
    return sizes


def _clock_history(connection: sa.Connection) -> ClockHistory | None:
    plain = connection.scalar(sa.select(CONTROL.c.clock))
    return None if plain is None else ClockHistory.from_json(plain)


# A registered file of a run that has ended, and that no sweep keeps.
_IS_DROPPED = sa.and_(
    ARTIFACTS.c.name.in_(KEPT_BY),
    sa.exists().where(JOBS.c.id == ARTIFACTS.c.job_id, JOBS.c.state.in_(TERMINAL)),
    sa.not_(
        sa.exists()
        .where(POINTS.c.run_id == ARTIFACTS.c.job_id, SWEEPS.c.id == POINTS.c.sweep_id)
        .where(
            sa.or_(*((ARTIFACTS.c.name == name) & SWEEPS.c.keep.in_(at_least(keep)) for name, keep in KEPT_BY.items()))
        )
    ),
)


def _keep_less(run_id: str, name: str) -> sa.Update:
    """Lower the retention of a run without this file; a sweep that wants it has it computed again."""
    less = list(Keep)[list(Keep).index(KEPT_BY[name]) - 1]
    run = JOBS.update().where(JOBS.c.id == run_id, JOBS.c.keep.in_(at_least(KEPT_BY[name])))
    return run.values(keep=less)
