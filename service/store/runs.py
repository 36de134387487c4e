"""Runs: what is asked, how far they are, their files and measurements."""

from collections import defaultdict
from collections.abc import Iterable
from typing import TYPE_CHECKING

import sqlalchemy as sa

from service.records.jobs import Kind, MeasuredRun, NotFound, RunPlace, RunRow, Stored, Summary
from service.store.connection import Repository
from service.store.events import log_event
from service.store.tables import (
    ARTIFACTS,
    IS_UNDER_WAY,
    JOBS,
    POINTS,
    RESULTS,
    SWEEPS,
    StatementRow,
    batches,
    begins,
    count_bytes,
    literal,
    now,
    runs_of,
    stored_record,
    sweeps_waiting_for,
)
from service.store.transitions import ended_by_accident, outdate_publications, release_publications
from studies.quantities.files import RESULT, STATE

if TYPE_CHECKING:
    from studies.runs.run import RunSpec

RUN_COLUMNS = [JOBS.c[field] for field in RunRow.__dataclass_fields__]


class Runs(Repository):
    """What is known of each run."""

    def get(self, id: str) -> RunRow:
        """One run; raises NotFound."""
        query = sa.select(*RUN_COLUMNS).where(JOBS.c.id == id, JOBS.c.kind == Kind.RUN)
        return run_record(self._database.row(query, "run", id))

    def with_prefix(self, prefix: str, limit: int) -> tuple[RunRow, ...]:
        """Runs whose ids begin so, in the order of their ids."""
        query = sa.select(*RUN_COLUMNS).where(JOBS.c.kind == Kind.RUN, begins(JOBS.c.id, prefix))
        return tuple(map(run_record, self._database.rows(query.order_by(JOBS.c.id).limit(limit))))

    def spec(self, id: str) -> "RunSpec":
        """A run as it is computed, complete; raises NotFound."""
        query = sa.select(JOBS.c.spec).where(JOBS.c.id == id, JOBS.c.kind == Kind.RUN)
        return self._database.row(query, "run", id).spec

    def places(self, id: str, most: int) -> tuple[RunPlace, ...]:
        """Where a run stands in the youngest sweeps that have it."""
        query = (
            sa.select(SWEEPS.c.id.label("sweep_id"), SWEEPS.c.title, SWEEPS.c.owner, POINTS.c.coordinates)
            .join_from(POINTS, SWEEPS, SWEEPS.c.id == POINTS.c.sweep_id)
            .where(POINTS.c.run_id == id)
            .order_by(SWEEPS.c.number.desc())
            .limit(most)
        )
        return tuple(RunPlace(**row._mapping) for row in self._database.rows(query))

    def known(self, ids: Iterable[str]) -> set[str]:
        """Those of these runs that are finished or under way, so that a sweep of them computes nothing new."""
        query = sa.select(JOBS.c.id).where(sa.not_(ended_by_accident()))
        with self._database.reading() as connection:
            return {id for batch in batches(ids) for id in connection.scalars(query.where(JOBS.c.id.in_(batch)))}

    def under_way(self) -> tuple[tuple[RunRow, tuple[str, ...]], ...]:
        """Runs that are running or being stopped, each with the sweeps that wait for it."""
        held = sa.and_(IS_UNDER_WAY, JOBS.c.kind == literal(Kind.RUN))
        waiting = (
            sa.select(POINTS.c.run_id, POINTS.c.sweep_id)
            .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
            .where(held, POINTS.c.detached.is_(False))
            .distinct()
            .order_by(POINTS.c.sweep_id)
        )
        sweeps = defaultdict(list)
        with self._database.reading() as connection:
            rows = connection.execute(sa.select(*RUN_COLUMNS).where(held))
            runs = [run_record(row) for row in rows]
            for row in connection.execute(waiting):
                sweeps[row.run_id].append(row.sweep_id)
        return tuple((run, tuple(sweeps[run.id])) for run in runs)

    def measured(self, sweep_id: str) -> tuple[MeasuredRun, ...]:
        """The runs of a sweep, each once, with what they measured and their final state; raises NotFound."""
        kept = (ARTIFACTS.c.job_id == JOBS.c.id) & (ARTIFACTS.c.name == STATE)
        query = (
            sa.select(JOBS.c.id.label("run_id"), JOBS.c.scenario, JOBS.c.state, JOBS.c.summary)
            .add_columns(ARTIFACTS.c.name, ARTIFACTS.c.path, ARTIFACTS.c.size, ARTIFACTS.c.sha256)
            .join_from(JOBS, ARTIFACTS, kept, isouter=True)
            .where(JOBS.c.id.in_(runs_of(sweep_id)))
            .order_by(JOBS.c.id)
        )
        rows = self._database.rows(query)
        if not rows:  # every sweep has runs
            raise NotFound("sweep", sweep_id)
        states = {row.run_id: stored_record(row) for row in rows if row.path is not None}
        return tuple(
            MeasuredRun(row.run_id, row.scenario, row.state, row.summary, states.get(row.run_id)) for row in rows
        )

    def measured_rate(self, scenario: str) -> float | None:
        """Measured seconds for each estimated core second, over all results of the scenario; None without."""
        query = sa.select(sa.func.sum(RESULTS.c.seconds), sa.func.sum(RESULTS.c.cost))
        [(seconds, cost)] = self._database.rows(query.where(RESULTS.c.scenario == scenario))
        return seconds / cost if cost else None

    # --- files -----------------------------------------------------------------------------------

    def file(self, id: str, name: str) -> Stored:
        """A file of a run; raises NotFound, also when it was not kept."""
        for file in self.files(id):
            if file.name == name:
                return file
        raise NotFound("file", f"{id}/{name}")

    def files(self, id: str) -> tuple[Stored, ...]:
        """The files of a run that has ended; raises NotFound for an unknown run."""
        query = (
            sa.select(ARTIFACTS)
            .join_from(JOBS, ARTIFACTS, ARTIFACTS.c.job_id == JOBS.c.id, isouter=True)
            .where(JOBS.c.id == id, JOBS.c.kind == Kind.RUN)
            .order_by(ARTIFACTS.c.name)
        )
        rows = self._database.rows(query)
        if not rows:
            raise NotFound("run", id)
        return tuple(stored_record(row) for row in rows if row.name is not None)

    def replace_result(self, id: str, was: str, answer: Stored, summary: Summary) -> tuple[str, ...]:
        """Replace the result of a run, if its SHA-256 is ``was``; return the sweeps to be published again.

        Those are the ones that were published with the earlier result, or are being published.
        """
        moment = now()
        file = {"path": answer.path, "size": answer.size, "sha256": answer.sha256}
        run = JOBS.update().where(JOBS.c.id == id, JOBS.c.sha256 == was)
        registered = ARTIFACTS.update().where(ARTIFACTS.c.job_id == id, ARTIFACTS.c.name == RESULT)
        publication = JOBS.c.sweep_id.in_(sweeps_waiting_for(id))
        with self._database.commanding() as connection:
            if not connection.execute(run.values(**file, summary=dict(summary))).rowcount:
                return ()
            connection.execute(registered.values(file))
            count_bytes(connection, JOBS.c.id == id)
            log_event(connection, moment, "remeasured", job_id=id, was=was, sha256=answer.sha256)
            marked = outdate_publications(connection, moment, publication)
            release_publications(connection, moment, publication)
        return marked


def run_record(row: StatementRow) -> RunRow:
    """A run from a row with RUN_COLUMNS."""
    return RunRow(**{field: row._mapping[JOBS.c[field]] for field in RunRow.__dataclass_fields__})
