"""The tables, and the expressions and statements over them that several parts of the store share.

``Database.migrate`` makes the tables in an empty database; later changes are migrations.
"""

from collections.abc import Iterable, Iterator
from datetime import UTC, datetime
from enum import StrEnum
from importlib import import_module
from itertools import islice
from typing import TYPE_CHECKING, Any, TypeVar

import sqlalchemy as sa

from service.records.jobs import ACTIVE, Cause, Keep, Kind, NotFound, State, Stored

if TYPE_CHECKING:
    from sqlalchemy.dialects import postgresql, sqlite


class UtcTime(sa.types.TypeDecorator[datetime]):
    """A moment in UTC; SQLite forgets the zone, PostgreSQL gives its own."""

    impl = sa.DateTime(timezone=True)
    cache_ok = True

    def process_result_value(self, value: datetime | None, dialect: sa.Dialect) -> datetime | None:
        if value is None:
            return None
        return value.astimezone(UTC) if value.tzinfo else value.replace(tzinfo=UTC)


def enumeration(kind: type[StrEnum]) -> sa.Enum:
    """The type of a column with values of an enumeration: text in the database, members in Python."""
    return sa.Enum(
        kind, native_enum=False, length=16, values_callable=lambda members: [member.value for member in members]
    )


Item = TypeVar("Item")
# A query of whatever columns, and a row of it.
Query = sa.Select[*tuple[Any, ...]]
StatementRow = sa.Row[*tuple[Any, ...]]
ROWS_PER_STATEMENT = 1000  # SQLite takes 32 766 parameters in a statement
JSON = sa.JSON(none_as_null=True)
TABLES = sa.MetaData()
# As alembic has it, which need not be imported to make tables.
REVISIONS = sa.Table("alembic_version", sa.MetaData(), sa.Column("version_num", sa.String(32), primary_key=True))
REVISION = "0.1.0.2"  # of these tables: that of the newest file of ``service/migrations/versions``

SWEEPS = sa.Table(
    "sweeps",
    TABLES,
    sa.Column("number", sa.Integer, primary_key=True),  # order of acceptance
    sa.Column("id", sa.String(32), unique=True, nullable=False),
    sa.Column("name", sa.Text, nullable=False),
    sa.Column("title", sa.Text, nullable=False),
    sa.Column("scenario", sa.Text, nullable=False),
    sa.Column("document", JSON, nullable=False),  # canonical
    sa.Column("digest", sa.String(64), nullable=False),  # of document and run ids
    sa.Column("owner", sa.Text, nullable=False),  # name of an API key; empty on the loopback
    sa.Column("priority", sa.Integer, nullable=False),  # smaller is sooner, as with nice
    sa.Column("keep", enumeration(Keep), nullable=False),
    sa.Column("planned", sa.Integer, nullable=False),
    sa.Column("new", sa.Integer, nullable=False),  # runs that it brought into the queue
    sa.Column("created", UtcTime, nullable=False),
    sa.Column("cancelled", UtcTime),
    sa.Column("pinned", UtcTime),  # since when it is kept from deletion
    sa.Column("physics", sa.Integer, nullable=False),  # version by which its points were expanded
    sa.Column("renewed", UtcTime),  # when they were expanded anew, by a newer version
    sa.Column("older", sa.String(32)),  # id of the sweep that has its results of older versions
    sa.Index("sweeps_digest", "digest"),
    sqlite_autoincrement=True,
)

# The queue: a run, or the publication of a sweep.
JOBS = sa.Table(
    "jobs",
    TABLES,
    sa.Column("id", sa.String(32), primary_key=True),  # of a run: its content id
    sa.Column("kind", enumeration(Kind), nullable=False),
    sa.Column("sweep_id", sa.ForeignKey("sweeps.id"), unique=True),  # of a publication
    # Of a publication: ordinal of a point that was unfinished at the last check.
    sa.Column("unfinished_point", sa.Integer),
    sa.Column("scenario", sa.Text),
    sa.Column("spec", JSON),  # complete specification of a run
    sa.Column("state", enumeration(State), nullable=False),
    sa.Column("priority", sa.Integer, nullable=False),  # of the most urgent sweep that waits for it
    # Of that sweep, whose share and quota pay; once it is deleted, of another one that has the run.
    sa.Column("owner", sa.Text, nullable=False),
    sa.Column("virtual_time", sa.Float, nullable=False),  # within the queue of priority and owner
    sa.Column("ordinal", sa.Integer, nullable=False),  # place in the sweep that brought it
    sa.Column("keep", enumeration(Keep), nullable=False),  # the most that a sweep asked for
    sa.Column("cost", sa.Float, nullable=False),  # estimated core seconds
    sa.Column("attempt", sa.Integer, nullable=False),
    sa.Column("term", sa.Integer, nullable=False),
    sa.Column("token", sa.String(16)),
    sa.Column("crashes", sa.Integer, nullable=False),  # at the same checkpoint
    sa.Column("crash_step", sa.Integer),  # of that checkpoint
    sa.Column("checkpoint", sa.Integer),  # step of the last one
    sa.Column("fraction", sa.Float),  # of the attempt, 1 for a result
    sa.Column("progress", JSON),
    sa.Column("cause", enumeration(Cause)),
    sa.Column("failure", sa.Text),
    sa.Column("reason", sa.Text),
    sa.Column("summary", JSON),
    sa.Column("path", sa.Text),
    sa.Column("size", sa.BigInteger),
    sa.Column("sha256", sa.String(64)),
    sa.Column("bytes", sa.BigInteger, nullable=False),  # of all its files: see ``count_bytes``
    sa.Column("seconds", sa.Float),  # of the attempt, wall clock
    sa.Column("created", UtcTime, nullable=False),
    sa.Column("queued", UtcTime, nullable=False),
    sa.Column("started", UtcTime),
    sa.Column("finished", UtcTime),
    sa.Column("abandoned", UtcTime),  # of a run: since when no sweep has it
    sa.Index("jobs_states", "state", "kind"),  # by which jobs are counted
)


def literal(text: str) -> sa.ColumnClause[str]:
    """A text that is no parameter: PostgreSQL groups by no expression with one, and no partial index serves one."""
    return sa.literal_column(f"'{text}'")


# Conditions on the state of a job, in the words of the partial indexes below: what has ended costs a query nothing.
IS_QUEUED = JOBS.c.state == literal(State.QUEUED)
IS_ACTIVE = JOBS.c.state.in_([literal(state) for state in State if state in ACTIVE])
HAS_ENDED = sa.not_(IS_ACTIVE)  # which is searched for through no index
IS_UNDER_WAY = IS_ACTIVE & JOBS.c.state.in_([literal(State.RUNNING), literal(State.CANCELLING)])


def _index(name: str, where: sa.ColumnElement[bool], *columns: str) -> None:
    """An index of those jobs that fulfil a condition, which a query must state in the same words."""
    index = sa.Index(name, *(JOBS.c[column] for column in columns))

    @sa.event.listens_for(TABLES, "before_create")
    def limit(_tables: sa.MetaData, connection: sa.Connection, **_: bool) -> None:
        # Here and not with the index, which would import the dialect of PostgreSQL for SQLite too.
        index.dialect_options[connection.dialect.name]["where"] = where


_index("jobs_queue", IS_QUEUED, "priority", "owner", "virtual_time", "ordinal")
_index("jobs_active", IS_ACTIVE, "state", "kind", "owner", "queued")
_index("jobs_abandoned", JOBS.c.abandoned.is_not(None), "abandoned")
_index("jobs_owned", JOBS.c.abandoned.is_(None), "owner", "bytes")
_index("jobs_published", JOBS.c.sweep_id.is_not(None), "finished")

POINTS = sa.Table(
    "points",
    TABLES,
    sa.Column("sweep_id", sa.ForeignKey("sweeps.id"), primary_key=True),
    sa.Column("ordinal", sa.Integer, primary_key=True),
    sa.Column("run_id", sa.ForeignKey("jobs.id"), nullable=False),
    sa.Column("axis_index", JSON, nullable=False),  # place on each axis
    sa.Column("coordinates", JSON, nullable=False),
    sa.Column("detached", sa.Boolean, nullable=False),  # the sweep no longer waits for it
    sa.Index("points_run", "run_id", "sweep_id"),
)

# Files of a run, and of the publication of a sweep.
ARTIFACTS = sa.Table(
    "artifacts",
    TABLES,
    sa.Column("job_id", sa.ForeignKey("jobs.id"), primary_key=True),
    sa.Column("name", sa.String(64), primary_key=True),
    sa.Column("path", sa.Text, nullable=False),
    sa.Column("size", sa.BigInteger, nullable=False),
    sa.Column("sha256", sa.String(64), nullable=False),
)

EVENTS = sa.Table(
    "events",
    TABLES,
    sa.Column("number", sa.Integer, primary_key=True),
    sa.Column("time", UtcTime, nullable=False),
    sa.Column("kind", sa.String(16), nullable=False),
    sa.Column("sweep_id", sa.String(32)),
    sa.Column("job_id", sa.String(32)),
    sa.Column("body", JSON, nullable=False),
    sa.Index("events_sweep", "sweep_id", "number"),
    sa.Index("events_job", "job_id", "number"),
    sqlite_autoincrement=True,  # a number is never given twice
)

# Terms of leadership; a lease carries the term that it was given in.
TERMS = sa.Table(
    "terms",
    TABLES,
    sa.Column("term", sa.Integer, primary_key=True),
    sa.Column("owner", sa.Text, nullable=False),
    sa.Column("started", UtcTime, nullable=False),
    sqlite_autoincrement=True,
)

# One row, which every writer locks before it does anything else.
CONTROL = sa.Table(
    "control",
    TABLES,
    sa.Column("id", sa.Integer, primary_key=True),
    sa.Column("paused", UtcTime),
    sa.Column("blocked_reason", sa.Text),
    # Of the remembered tallies of sweeps: grows when points that had ended are queued again.
    sa.Column("cache_generation", sa.Integer, nullable=False),
    sa.Column("data_id", sa.String(32)),  # of the data directory that belongs to this database
    # Lost results that may be forgotten beyond the limits, on request.
    sa.Column("forgettable", sa.Integer, nullable=False),
    sa.Column("scrub", JSON),  # how far the comparison of all files with their digests is
    sa.Column("clock", JSON),  # jumps of the wall clock, and what went by age lately
)

# The queue of an owner in a priority class: see ``fair_queueing``.
SHARES = sa.Table(
    "shares",
    TABLES,
    sa.Column("priority", sa.Integer, primary_key=True, autoincrement=False),
    sa.Column("owner", sa.Text, primary_key=True),
    sa.Column("virtual_time", sa.Float, nullable=False),  # of its run leased last
    sa.Column("served", sa.Float, nullable=False),  # cost of the runs leased so far, from where the owner began
)

KEYS = sa.Table(
    "keys",
    TABLES,
    sa.Column("id", sa.String(32), primary_key=True),
    sa.Column("name", sa.Text, nullable=False),
    sa.Column("prefix", sa.String(16), nullable=False),  # of the secret
    sa.Column("sha256", sa.String(64), nullable=False),  # of the secret
    sa.Column("scopes", sa.Text, nullable=False),  # separated by spaces
    sa.Column("created", UtcTime, nullable=False),
    sa.Column("expires", UtcTime),
    sa.Column("used", UtcTime),
    sa.Column("revoked", UtcTime),
    sa.Index("keys_prefix", "prefix"),
)

# Browsers that are logged in; a session ends at its time, at log-out, and with its key.
SESSIONS = sa.Table(
    "sessions",
    TABLES,
    sa.Column("sha256", sa.String(64), primary_key=True),  # digest of the secret that the cookie carries
    sa.Column("key_id", sa.ForeignKey("keys.id"), nullable=False),
    sa.Column("expires", UtcTime, nullable=False),
)

# The audit trail: orders and refused keys. Rows are added, never changed.
AUDIT = sa.Table(
    "audit",
    TABLES,
    sa.Column("number", sa.Integer, primary_key=True),
    sa.Column("time", UtcTime, nullable=False),
    sa.Column("key_id", sa.String(32)),
    *(sa.Column(name, sa.Text, nullable=False) for name in ("owner", "address", "action", "subject", "outcome")),
    sa.Index("audit_time", "time"),
    sqlite_autoincrement=True,
)

# Idempotency keys of accepted submissions.
IDEMPOTENCY = sa.Table(
    "idempotency",
    TABLES,
    sa.Column("owner", sa.Text, primary_key=True),
    sa.Column("key", sa.Text, primary_key=True),
    sa.Column("digest", sa.String(64), nullable=False),  # of the body
    sa.Column("sweep_id", sa.ForeignKey("sweeps.id"), nullable=False),
    sa.Index("idempotency_sweep", "sweep_id"),
)

# Attempts without success since the store was made, by cause.
CAUSES = sa.Table(
    "causes",
    TABLES,
    sa.Column("cause", enumeration(Cause), primary_key=True),
    sa.Column("attempts", sa.BigInteger, nullable=False),
)

# Attempts with a result since the store was made: a success, or the solver's verdict.
RESULTS = sa.Table(
    "results",
    TABLES,
    sa.Column("scenario", sa.Text, primary_key=True),
    sa.Column("succeeded", sa.Boolean, primary_key=True),
    sa.Column("bucket", sa.Integer, primary_key=True, autoincrement=False),  # edges of RUN_SECONDS that they exceed
    sa.Column("attempts", sa.BigInteger, nullable=False),
    sa.Column("seconds", sa.Float, nullable=False),  # measured, of all of them
    sa.Column("cost", sa.Float, nullable=False),  # estimated core seconds
)

# --- expressions -------------------------------------------------------------------------------

PUBLICATIONS = JOBS.alias("publications")
PUBLISH_PRIORITY = -1000  # a finished sweep is published before more runs begin


# Where a point stands for its sweep: cancelled once the sweep no longer waits for the run.
POINT_STATE = sa.type_coerce(
    sa.case((POINTS.c.detached, literal(State.CANCELLED)), else_=sa.type_coerce(JOBS.c.state, sa.Text)),
    enumeration(State),
)


def runs_of(sweep_id: str) -> sa.Select[str]:
    """The ids of the runs of a sweep."""
    return sa.select(POINTS.c.run_id).where(POINTS.c.sweep_id == sweep_id)


# Also true of a run that is computed again; never of a publication.
HAS_RESULT = JOBS.c.path.is_not(None)


# --- statements --------------------------------------------------------------------------------


def insert_into(connection: sa.Connection, table: sa.Table) -> "sqlite.Insert | postgresql.Insert":
    """An insert that can say what to do with rows that are there already."""
    insert: sqlite.Insert | postgresql.Insert
    insert = import_module(f"sqlalchemy.dialects.{connection.dialect.name}").insert(table)
    return insert


def invalidate_tallies(connection: sa.Connection, points: int) -> None:
    """Note that so many points that had ended are unfinished again: see ``time_left.Tallies``."""
    connection.execute(CONTROL.update().values(cache_generation=CONTROL.c.cache_generation + points))


def count_bytes(connection: sa.Connection, which: sa.ColumnElement[bool]) -> None:
    """Note the bytes of the files of those jobs, after some were registered or unregistered."""
    size = sa.select(sa.func.coalesce(sa.func.sum(ARTIFACTS.c.size), 0)).where(ARTIFACTS.c.job_id == JOBS.c.id)
    connection.execute(JOBS.update().where(which).values(bytes=size.correlate(JOBS).scalar_subquery()))


def begins(column: sa.ColumnElement[str], prefix: str) -> sa.ColumnElement[bool]:
    """The id, of hexadecimal digits, begins so; by its index."""
    return sa.and_(column >= prefix, column < prefix + "g")


def one_row(connection: sa.Connection, query: Query, kind: str, id: str) -> StatementRow:
    """The single row of a query; raises NotFound."""
    row = connection.execute(query).first()
    if row is None:
        raise NotFound(kind, id)
    return row


def count(connection: sa.Connection, *conditions: sa.ColumnElement[bool]) -> int:
    """Number of rows that fulfil the conditions, all of one table."""
    return connection.execute(sa.select(sa.func.count()).where(*conditions)).scalar_one()


def sweeps_waiting_for(run_id: str) -> sa.Select[str]:
    """The ids of the sweeps that a run counts for: those that did not stop to wait for it."""
    return sa.select(POINTS.c.sweep_id).where(POINTS.c.run_id == run_id, POINTS.c.detached.is_(False))


def stored_record(row: StatementRow) -> Stored:
    """A file from a row of ARTIFACTS."""
    return Stored(name=row.name, path=row.path, size=row.size, sha256=row.sha256)


# --- rows, moments, batches -------------------------------------------------------------------


def now() -> datetime:
    """This moment; it decides whether a key has expired and when an unused run is removed, nothing else."""
    return datetime.now(UTC)


def batches(items: Iterable[Item], size: int = ROWS_PER_STATEMENT) -> Iterator[list[Item]]:
    """Items in lists of limited size, by default short enough for one statement."""
    left = iter(items)
    while batch := list(islice(left, size)):
        yield batch
