"""What the care of the data directory asks of the rows: which files still count."""

from collections.abc import Iterable, Mapping, Sequence

import sqlalchemy as sa

from service.jobs import TERMINAL, Attempt, Keep, Stored, at_least
from service.store.connection import Part
from service.store.queries import batches
from service.store.rows import stored_record
from service.store.tables import ARTIFACTS, EVENTS, JOBS, POINTS, SWEEPS

# Files of a run that only some sweeps keep: whoever asks for this or for more does.
KEPT_BY = {"state.npz": Keep.FINAL, "film.npz": Keep.FILM}
BY_JOB = [ARTIFACTS.c.job_id, ARTIFACTS.c.name]


class Care(Part):
    """Files that may go, and those that nobody knows."""

    def discardable(self, limit: int) -> tuple[tuple[str, Stored], ...]:
        """Registered files that no sweep keeps, each with its run; delete, then ``forget_files``."""
        keeps = (
            sa.exists()
            .where(POINTS.c.run_id == ARTIFACTS.c.job_id, SWEEPS.c.id == POINTS.c.sweep_id)
            .where(sa.or_(*(_keeps(name, keep) for name, keep in KEPT_BY.items())))
        )
        query = (
            sa.select(ARTIFACTS)
            .join(JOBS, JOBS.c.id == ARTIFACTS.c.job_id)
            .where(ARTIFACTS.c.name.in_(KEPT_BY), JOBS.c.state.in_(TERMINAL), sa.not_(keeps))
        )
        return self._files(query.limit(limit))

    def forget_files(self, job_id: str, names: Iterable[str]) -> None:
        """Files that are no longer there."""
        gone = ARTIFACTS.delete().where(ARTIFACTS.c.job_id == job_id)
        with self._database.writing() as connection:
            connection.execute(gone.where(ARTIFACTS.c.name.in_([*names])))

    def files(
        self, *, after: tuple[str, str] = ("", ""), limit: int = 1000
    ) -> tuple[tuple[str, Stored], ...]:
        """Every registered file, by job and name; ``after`` is the last one of the page before."""
        query = sa.select(ARTIFACTS).where(sa.tuple_(*BY_JOB) > sa.tuple_(*after))
        return self._files(query.limit(limit))

    def known_attempts(self, job_ids: Iterable[str]) -> Mapping[str, Attempt]:
        """The last attempt of each of these jobs; those that are unknown are left out."""
        query = sa.select(JOBS.c.id, JOBS.c.attempt, JOBS.c.token, JOBS.c.state)
        with self._database.reading() as connection:
            return {
                row.id: Attempt(row.attempt, row.token, row.state)
                for batch in batches(job_ids)
                for row in connection.execute(query.where(JOBS.c.id.in_(batch)))
            }

    def forgotten(self, sweep_ids: Sequence[str]) -> set[str]:
        """Those of these sweeps that were deleted here; one that this store never had is not."""
        query = sa.select(EVENTS.c.sweep_id).where(EVENTS.c.kind == "deleted")
        with self._database.reading() as connection:
            return {
                id
                for batch in batches(sweep_ids)
                for id in connection.scalars(query.where(EVENTS.c.sweep_id.in_(batch)))
            }

    def _files(self, query: sa.Select[tuple[object, ...]]) -> tuple[tuple[str, Stored], ...]:
        with self._database.reading() as connection:
            rows = connection.execute(query.order_by(*BY_JOB)).all()
        return tuple((row.job_id, stored_record(row)) for row in rows)


def _keeps(name: str, keep: Keep) -> sa.ColumnElement[bool]:
    return (ARTIFACTS.c.name == name) & SWEEPS.c.keep.in_(at_least(keep))
