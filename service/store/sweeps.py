"""Sweeps: what people do with them, where they stand, and what they hold.

A sweep that searches for a limit is extended: its publication is leased when all runs have ended, and waits again where
the results ask for further ones. Nothing is stored beyond the document and the results, so that restart, cancel and
retry are those of any sweep.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import product
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from service.records.expansion import ExpandedSweep, expand, expanded_points
from service.records.jobs import (
    SWEEP_TERMINAL,
    Conflict,
    GridCell,
    Lease,
    Page,
    PointRow,
    State,
    Stored,
    Submission,
    SweepState,
    SweepStatus,
)
from service.records.logbook import PAGE, Column, Logbook, LogbookEntry, Wanted
from service.store import fair_queueing, transitions
from service.store.connection import Database, Repository
from service.store.events import log_event
from service.store.runs import RUN_COLUMNS, run_record
from service.store.submission import accept, accepted_before, add_points, check_quota
from service.store.tables import (
    ARTIFACTS,
    CONTROL,
    IDEMPOTENCY,
    JOBS,
    JSON,
    POINT_STATE,
    POINTS,
    PUBLICATIONS,
    SWEEPS,
    Query,
    StatementRow,
    batches,
    begins,
    enumeration,
    invalidate_tallies,
    literal,
    now,
    one_row,
)
from service.store.time_left import Tallies, counts_of, progress_of, seconds_left, tallies_of
from studies.quantities.findings import Finding, InvalidInput

if TYPE_CHECKING:
    from pydantic import JsonValue

    from studies.quantities.parameters import Plain
    from studies.sweeps.sweep import Point

# A subquery of one row in place of EXISTS, which PostgreSQL would evaluate for all sweeps of the store.
_IS_BEGUN = (
    sa.select(sa.true())
    .where(POINTS.c.sweep_id == SWEEPS.c.id, JOBS.c.id == POINTS.c.run_id, JOBS.c.state != State.QUEUED)
    .limit(1)
    .correlate(SWEEPS)
    .scalar_subquery()
    .is_not(None)
)

# Where a sweep stands, from its publication and its runs.
SWEEP_STATE = sa.type_coerce(
    sa.case(
        (PUBLICATIONS.c.state == State.FAILED, literal(SweepState.FAILED)),
        (PUBLICATIONS.c.state == State.CANCELLED, literal(SweepState.CANCELLED)),
        (sa.and_(PUBLICATIONS.c.state == State.SUCCEEDED, SWEEPS.c.cancelled.is_(None)), literal(SweepState.SUCCEEDED)),
        (PUBLICATIONS.c.state == State.SUCCEEDED, literal(SweepState.CANCELLED)),
        (SWEEPS.c.cancelled.is_not(None), literal(SweepState.CANCELLING)),
        (PUBLICATIONS.c.state != State.WAITING, literal(SweepState.PUBLISHING)),
        (_IS_BEGUN, literal(SweepState.RUNNING)),
        else_=literal(SweepState.QUEUED),
    ),
    enumeration(SweepState),
)

# A sweep with its state, without its document, which may be long.
SWEEP_ROWS = sa.select(
    *(SWEEPS.c[name] for name in ("number", "id", "name", "title", "scenario", "planned", "new")),
    *(SWEEPS.c[name] for name in ("owner", "priority", "keep", "created", "cancelled", "pinned")),
    *(SWEEPS.c[name] for name in ("physics", "renewed", "older")),
    SWEEP_STATE.label("state"),
    *(PUBLICATIONS.c.reason, PUBLICATIONS.c.finished),
    PUBLICATIONS.c.summary["headline"].as_string().label("headline"),
    sa.select(CONTROL.c.cache_generation).scalar_subquery().label("cache_generation"),
).join_from(SWEEPS, PUBLICATIONS, PUBLICATIONS.c.sweep_id == SWEEPS.c.id)


NAME = re.compile(r"[\w.-]+")  # of a material
MOST_COMPARED = 20_000  # characters of a document that is set beside others of the same title
MOST_WORDS = 8  # of a search; the last one is all that is left
# Names of the files that a sweep has published, separated by spaces; null: there are none.
FILE_NAMES = (
    sa.select(sa.func.aggregate_strings(ARTIFACTS.c.name, " "))
    .where(ARTIFACTS.c.job_id == PUBLICATIONS.c.id)
    .correlate(PUBLICATIONS)
    .scalar_subquery()
    .label("files")
)
SWEEPS_AND_FILES = SWEEP_ROWS.add_columns(FILE_NAMES)


class Sweeps(Repository):
    """What people do with sweeps, and how they stand."""

    def __init__(self, database: Database):
        super().__init__(database)
        self._tallies = Tallies()

    # --- commands --------------------------------------------------------------------------------

    def create(self, submission: Submission) -> SweepStatus:
        """Accept a sweep: its row, runs, points and publication, or nothing at all.

        A run that is finished is linked, one that is under way is joined, one that an accident or a
        cancel ended is queued again. A submission with the idempotency key and body of an earlier one
        is the earlier sweep; with another body it raises KeyReused. Raises InvalidInput and QuotaExceeded.
        """
        if submission.idempotency is not None:
            with self._database.reading() as connection:
                earlier = accepted_before(connection, submission)
                if earlier is not None:
                    return sweep_status(connection, earlier)
        if submission.findings:
            raise InvalidInput(submission.findings)
        sweep = submission.sweep
        if not isinstance(sweep, ExpandedSweep):
            sweep = expand(sweep)
        moment = now()
        with self._database.commanding() as connection:
            earlier = accepted_before(connection, submission)
            if earlier is not None:
                return sweep_status(connection, earlier)
            check_quota(connection, submission, sweep)
            status = sweep_status(connection, accept(connection, submission, sweep, moment))
            log_event(connection, moment, "accepted", sweep_id=status.id, planned=status.planned, new=status.new)
            return status

    def extend(self, lease: Lease, points: "Sequence[Point]") -> bool:
        """Add points to the sweep of a leased publication, which waits for them.

        Without effect (False) where the sweep was cancelled, or the lease has ended.
        """
        id, moment = lease.sweep_id, now()
        assert id is not None
        is_wanted = sa.exists().where(SWEEPS.c.id == id, SWEEPS.c.cancelled.is_(None))
        last = sa.select(sa.func.max(POINTS.c.ordinal)).where(POINTS.c.sweep_id == id)
        with self._database.commanding() as connection:
            if not transitions.wait_again(connection, lease, is_wanted):
                return False
            first = connection.execute(last).scalar_one() + 1
            new = add_points(connection, id, [*expanded_points(points)], moment, first)
            counts = {"planned": SWEEPS.c.planned + len(points), "new": SWEEPS.c.new + new}
            connection.execute(SWEEPS.update().where(SWEEPS.c.id == id).values(counts))
            # The tally of a sweep whose points had all ended may be remembered.
            invalidate_tallies(connection, len(points))
            transitions.release_publications(connection, moment, JOBS.c.sweep_id == id)
            log_event(connection, moment, "extended", sweep_id=id, points=len(points), new=new)
        return True

    def cancel(self, id: str) -> SweepStatus:
        """Stop waiting for runs that are not done; results so far are published.

        Runs that no other sweep waits for leave the queue, or are to be stopped; the others take
        the priority of those that wait. A sweep that is being published, or is done, stays as it is;
        but one that searches for a limit is published without further runs.
        """
        moment = now()
        publishing = SWEEP_ROWS.with_only_columns(SWEEPS.c.document).where(SWEEPS.c.id == id)
        publishing = publishing.where(SWEEP_STATE.in_([SweepState.PUBLISHING]))
        with self._database.commanding() as connection:
            detached = transitions.detach(connection, id)
            if detached or is_search(connection.scalar(publishing) or {}):
                connection.execute(SWEEPS.update().where(SWEEPS.c.id == id).values(cancelled=moment))
                transitions.cancel(connection, id, moment)
                log_event(connection, moment, "cancelled", sweep_id=id, points=detached)
            return sweep_status(connection, id)

    def retry(self, id: str, *, verdicts: bool = False) -> SweepStatus:
        """Queue again what an accident or a cancel ended (``verdicts``: the solver's too), then publish."""
        moment = now()
        publication = sa.select(JOBS.c.state).where(JOBS.c.sweep_id == id)
        attach = POINTS.update().where(POINTS.c.sweep_id == id).values(detached=False)
        with self._database.commanding() as connection:
            row = one_row(connection, publication, "sweep", id)
            if row.state is State.RUNNING:
                raise Conflict("the sweep is being published; retry it afterwards")
            connection.execute(SWEEPS.update().where(SWEEPS.c.id == id).values(cancelled=sa.null()))
            invalidate_tallies(connection, connection.execute(attach).rowcount)
            transitions.publish_again(connection, id)
            again = transitions.retry(connection, id, moment, verdicts=verdicts)
            fair_queueing.schedule(connection, id)
            transitions.release_publications(connection, moment, JOBS.c.sweep_id == id)
            log_event(connection, moment, "retried", sweep_id=id, runs=again)
            return sweep_status(connection, id)

    def set_priority(self, id: str, priority: int) -> SweepStatus:
        """Let a sweep's runs come sooner or later; a shared run follows the most urgent sweep."""
        with self._database.commanding() as connection:
            sweep = sweep_status(connection, id)
            if sweep.state in SWEEP_TERMINAL:
                raise Conflict(f"the sweep has ended; it is {sweep.state}")
            fair_queueing.open_queue(connection, priority, sweep.owner)
            connection.execute(SWEEPS.update().where(SWEEPS.c.id == id).values(priority=priority))
            fair_queueing.follow_urgency(connection, id)
            log_event(connection, now(), "prioritised", sweep_id=id, priority=priority)
            return sweep_status(connection, id)

    def pin(self, id: str, *, pinned: bool) -> SweepStatus:
        """Keep a sweep from being deleted, or no longer; without effect where it is so already."""
        moment = now()
        is_other = SWEEPS.c.pinned.is_(None) if pinned else SWEEPS.c.pinned.is_not(None)
        change = SWEEPS.update().where(SWEEPS.c.id == id, is_other).values(pinned=moment if pinned else None)
        with self._database.writing() as connection:
            if connection.execute(change).rowcount:
                log_event(connection, moment, "pinned" if pinned else "unpinned", sweep_id=id)
            return sweep_status(connection, id)

    def delete(self, id: str) -> None:
        """Delete a sweep that has ended; its runs stay for a while, since other sweeps may need them."""
        own = sa.select(JOBS.c.id).where(JOBS.c.sweep_id == id)
        moment = now()
        with self._database.commanding() as connection:
            status = sweep_status(connection, id)
            state = status.state
            if status.pinned is not None:
                raise Conflict("the sweep is pinned; unpin it (`whipple change --unpin`), then delete it")
            if state not in SWEEP_TERMINAL:
                stopping = state is SweepState.CANCELLING
                cure = "delete it once it is cancelled" if stopping else "cancel it, then delete it"
                raise Conflict(f"the sweep is {state}; {cure}")
            transitions.leave_runs(connection, id, moment)
            connection.execute(ARTIFACTS.delete().where(ARTIFACTS.c.job_id.in_(own)))
            for table in (IDEMPOTENCY, POINTS, JOBS):
                connection.execute(table.delete().where(table.c.sweep_id == id))
            connection.execute(SWEEPS.delete().where(SWEEPS.c.id == id))
            log_event(connection, moment, "deleted", sweep_id=id)

    # --- queries ---------------------------------------------------------------------------------

    def get(self, id: str) -> SweepStatus:
        """One sweep; raises NotFound."""
        return self._get(id, SWEEP_ROWS)[0]

    def statuses(self, ids: Iterable[str]) -> Mapping[str, SweepStatus]:
        """These sweeps by their ids, in two statements for each thousand; unknown ones are left out."""
        with self._database.reading() as connection:
            queries = (SWEEP_ROWS.where(SWEEPS.c.id.in_(batch)) for batch in batches(ids))
            statuses = (self._statuses(connection, connection.execute(query).all()) for query in queries)
            return {status.id: status for batch in statuses for status in batch}

    def get_with_files(self, id: str) -> tuple[SweepStatus, Sequence[str]]:
        """One sweep, and the names of the files that it has published; raises NotFound."""
        status, row = self._get(id, SWEEPS_AND_FILES)
        return status, _names(row)

    def get_with_file(self, id: str, name: str) -> tuple[SweepStatus, Stored | None]:
        """One sweep, and the file of this name if it has published one; raises NotFound."""
        published = (ARTIFACTS.c.job_id == PUBLICATIONS.c.id) & (ARTIFACTS.c.name == name)
        query = SWEEP_ROWS.add_columns(ARTIFACTS.c.path, ARTIFACTS.c.size, ARTIFACTS.c.sha256)
        status, row = self._get(id, query.outerjoin(ARTIFACTS, published))
        return status, None if row.path is None else Stored(name, row.path, row.size, row.sha256)

    def _get(self, id: str, query: Query) -> tuple[SweepStatus, StatementRow]:
        """One sweep, and its row of the query, which has the columns of SWEEP_ROWS and more."""
        with self._database.reading() as connection:
            row = one_row(connection, query.where(SWEEPS.c.id == id), "sweep", id)
            return self._statuses(connection, [row])[0], row

    def page(
        self, *, state: SweepState | None = None, prefix: str = "", cursor: str | None = None, limit: int = PAGE
    ) -> Page[SweepStatus]:
        """Sweeps whose ids begin so, the youngest first: two statements, whatever the number of runs."""
        query = SWEEP_ROWS.where(begins(SWEEPS.c.id, prefix)).order_by(SWEEPS.c.number.desc()).limit(limit + 1)
        if cursor is not None:
            query = query.where(SWEEPS.c.number < number_of(cursor))
        if state is not None:
            query = query.where(SWEEP_STATE.in_([state]))
        with self._database.reading() as connection:
            rows = connection.execute(query).all()
            items = self._statuses(connection, rows[:limit])
        return Page(items, str(rows[limit - 1].number) if len(rows) > limit else None)

    def logbook(self, wanted: Wanted) -> Logbook:
        """Sweeps with what a list shows of them, and the state of the queue: two statements."""
        page = _listed(wanted).subquery()
        key = page.c.key.asc() if wanted.ascending else page.c.key.desc()
        is_alike = sa.func.count().over(partition_by=page.c.title) > 1
        document = sa.type_coerce(sa.case((is_alike, page.c.document)), JSON).label("of_alike")
        query = (
            sa.select(CONTROL.c.paused, CONTROL.c.blocked_reason, page, document)
            .select_from(CONTROL.outerjoin(page, sa.true()))  # the table has exactly one row
            .order_by(key, page.c.number.desc())
        )
        with self._database.reading() as connection:
            rows = connection.execute(query).all()
            of_sweeps = [row for row in rows if row.id is not None]
            statuses = self._statuses(connection, of_sweeps[: wanted.limit])
        entries = tuple(
            LogbookEntry(
                status, _names(row), tuple(dict.fromkeys(NAME.findall(row.made_of))), row.axes or {}, row.of_alike
            )
            for status, row in zip(statuses, of_sweeps, strict=False)
        )
        return Logbook(entries, len(of_sweeps) > wanted.limit, rows[0].paused, rows[0].blocked_reason)

    def document(self, id: str) -> "Mapping[str, JsonValue]":
        """The document of a sweep, canonical; raises NotFound."""
        return self._database.row(sa.select(SWEEPS.c.document).where(SWEEPS.c.id == id), "sweep", id).document

    def find(self, digest: str) -> SweepStatus | None:
        """The youngest sweep with this ``digest_of``: the same document for the same physics."""
        query = SWEEP_ROWS.where(SWEEPS.c.digest == digest).order_by(SWEEPS.c.number.desc())
        with self._database.reading() as connection:
            rows = connection.execute(query.limit(1)).all()
            return self._statuses(connection, rows)[0] if rows else None

    def points(
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
        ordinal = POINTS.c.ordinal
        items = tuple(
            PointRow(row._mapping[ordinal], tuple(row.axis_index), row.coordinates, row.point_state, run_record(row))
            for row in rows[:limit]
        )
        return Page(items, str(items[-1].ordinal) if len(rows) > limit else None)

    def cells(self, id: str, ordinals: Sequence[int], quantity: str) -> tuple[GridCell, ...]:
        """These points of a sweep, each with the value of a quantity: one statement, at most ROWS_PER_STATEMENT."""
        value, uncertainty = (
            JOBS.c.summary["measurements", quantity, part].as_float().label(part) for part in ("value", "uncertainty")
        )
        query = (
            sa.select(POINTS.c.ordinal, POINTS.c.run_id, POINTS.c.coordinates, POINT_STATE.label("state"))
            .add_columns(JOBS.c.fraction, value, uncertainty)
            .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
            .where(POINTS.c.sweep_id == id, POINTS.c.ordinal.in_(ordinals))
            .order_by(POINTS.c.ordinal)
        )
        return tuple(GridCell(**row._mapping) for row in self._database.rows(query))

    def _statuses(self, connection: sa.Connection, rows: Sequence[StatementRow]) -> tuple[SweepStatus, ...]:
        tallies = self._tallies.of(connection, rows)
        return tuple(_status(row, tallies[row.id]) for row in rows)


def is_search(document: "Mapping[str, Plain]") -> bool:
    """Whether a document asks for a limit, so that the results of its sweep may ask for further runs."""
    axes = document.get("axes")
    return isinstance(axes, Mapping) and any(isinstance(it, Mapping) and "limit_of" in it for it in axes.values())


def sweep_status(connection: sa.Connection, id: str) -> SweepStatus:
    """One sweep within a transaction; raises NotFound."""
    row = one_row(connection, SWEEP_ROWS.where(SWEEPS.c.id == id), "sweep", id)
    return _status(row, tallies_of(connection, [id])[id])


def _status(row: StatementRow, tally: Sequence[StatementRow]) -> SweepStatus:
    """A sweep from its row and its tally."""
    return SweepStatus(
        **{name: getattr(row, name) for name in _STORED},
        reused=row.planned - row.new,
        counts=counts_of(tally),
        lost_answers=sum(part.reasons for part in tally if part.point_state is State.SUCCEEDED),
        progress=progress_of(tally),
        eta_seconds=seconds_left(tally),
    )


_COUNTED = frozenset({"reused", "counts", "lost_answers", "progress", "eta_seconds"})
_STORED = frozenset(SweepStatus.__dataclass_fields__) - _COUNTED


def _listed(wanted: Wanted) -> Query:
    """The sweeps of a list with the key of their order, and one more to know whether there are others."""
    keys: Mapping[Column, sa.ColumnElement[Any]] = {
        "submitted": SWEEPS.c.number,
        "title": sa.func.lower(SWEEPS.c.title),
        "scenario": SWEEPS.c.scenario,
        "materials": made_of(),
        "runs": SWEEPS.c.planned,
    }
    key = keys[wanted.order]
    is_short = sa.func.length(sa.cast(SWEEPS.c.document, sa.Text)) <= MOST_COMPARED
    document = sa.type_coerce(sa.case((is_short, SWEEPS.c.document)), JSON).label("document")
    query = SWEEPS_AND_FILES.add_columns(
        made_of().label("made_of"), SWEEPS.c.document["axes"].label("axes"), document, key.label("key")
    )
    if words := [_has(word) for word in wanted.text.split(maxsplit=MOST_WORDS - 1)]:
        query = query.where(sa.or_(sa.and_(*words), SWEEPS.c.id.istartswith(wanted.text, autoescape=True)))
    if wanted.state is not None:
        query = query.where(SWEEP_STATE.in_([wanted.state]))
    if wanted.scenario:
        query = query.where(SWEEPS.c.scenario == wanted.scenario)
    if wanted.material:
        query = query.where(made_of().icontains(wanted.material, autoescape=True))
    if wanted.owner is not None:
        query = query.where(SWEEPS.c.owner == wanted.owner)
    query = query.order_by(key.asc() if wanted.ascending else key.desc(), SWEEPS.c.number.desc())
    return query.offset(wanted.first).limit(wanted.limit + 1)


@cache
def made_of() -> sa.ColumnElement[str]:
    """The materials that a document names, fixed or as axes, with spaces between."""
    from studies import scenarios  # a tenth of a second, and few queries need them

    roles = dict.fromkeys(role for name in scenarios.names() for role in scenarios.load(name).materials)
    names: sa.ColumnElement[str] = sa.literal("")
    for part, role in product(("fixed", "axes"), roles):
        names = names + " " + sa.func.coalesce(SWEEPS.c.document[part, role].as_string(), "")
    return names


def _has(word: str) -> sa.ColumnElement[bool]:
    """Whether a sweep has a word, also in the title of its scenario or of a material that ships."""
    from studies import materials, scenarios

    setups = {name: scenarios.load(name) for name in scenarios.names()}
    of_scenarios = [name for name, setup in setups.items() if word.lower() in setup.title.lower()]
    of_materials = [name for name in materials.names() if word.lower() in materials.load(name).title.lower()]
    named = [SWEEPS.c[name].icontains(word, autoescape=True) for name in ("title", "name", "scenario")]
    made = [made_of().icontains(name, autoescape=True) for name in (word, *of_materials)]
    return sa.or_(*named, SWEEPS.c.scenario.in_(of_scenarios), *made)


def _names(row: StatementRow) -> Sequence[str]:
    """The file names of a row with FILE_NAMES."""
    return tuple(sorted((row.files or "").split()))


def number_of(cursor: str) -> int:
    """The number in a cursor; raises InvalidInput."""
    if not cursor.isascii() or not cursor.isdigit() or len(cursor) > 18:
        limit = "the cursor of an earlier page"
        raise InvalidInput([Finding("cursor", repr(cursor[:40]), limit, "omit the cursor for the first page")])
    return int(cursor)
