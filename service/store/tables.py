"""The tables. ``Database.migrate`` makes them in an empty database; later changes are migrations."""

from datetime import UTC, datetime
from enum import StrEnum

import sqlalchemy as sa

from service.records.jobs import Cause, Keep, Kind, State


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


JSON = sa.JSON(none_as_null=True)
TABLES = sa.MetaData()
REVISION = "0006"  # of these tables: that of the newest file of ``service/migrations/versions``

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
    sa.Column("virtual_time", sa.Float, nullable=False),  # within its priority class
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
    sa.Column("seconds", sa.Float),  # of the attempt, wall clock
    sa.Column("created", UtcTime, nullable=False),
    sa.Column("queued", UtcTime, nullable=False),
    sa.Column("started", UtcTime),
    sa.Column("finished", UtcTime),
    sa.Column("abandoned", UtcTime),  # of a run: when a sweep that had it was last deleted
    sa.Index("jobs_abandoned", "abandoned"),
    sa.Index("jobs_queue", "state", "priority", "virtual_time", "ordinal"),
)

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
)

# Sweeps of one priority; the virtual time of a class is that of its run leased last.
PRIORITY_CLASSES = sa.Table(
    "priority_classes",
    TABLES,
    sa.Column("priority", sa.Integer, primary_key=True, autoincrement=False),
    sa.Column("virtual_time", sa.Float, nullable=False),
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
