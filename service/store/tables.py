"""What is stored. The migrations make these tables; a test compares the two."""

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


def words(kind: type[StrEnum]) -> sa.Enum:
    """A column of words: text in the database, members in Python."""
    return sa.Enum(
        kind,
        native_enum=False,
        length=16,
        values_callable=lambda members: [member.value for member in members],
    )


JSON = sa.JSON(none_as_null=True)
TABLES = sa.MetaData()

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
    sa.Column("keep", words(Keep), nullable=False),
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
    sa.Column("kind", words(Kind), nullable=False),
    sa.Column("sweep_id", sa.ForeignKey("sweeps.id"), unique=True),  # of a publication
    sa.Column("witness", sa.Integer),  # of a publication: ordinal of a point that it waits for
    sa.Column("scenario", sa.Text),
    sa.Column("spec", JSON),  # of a run: the whole question
    sa.Column("state", words(State), nullable=False),
    sa.Column("priority", sa.Integer, nullable=False),  # of the most urgent sweep that waits for it
    sa.Column("turn", sa.Float, nullable=False),  # among those of its priority, see LANES
    sa.Column("ordinal", sa.Integer, nullable=False),  # place in the sweep that brought it
    sa.Column("keep", words(Keep), nullable=False),  # the most that a sweep asked for
    sa.Column("cost", sa.Float, nullable=False),  # estimated core seconds
    sa.Column("attempt", sa.Integer, nullable=False),
    sa.Column("epoch", sa.Integer, nullable=False),
    sa.Column("token", sa.String(16)),
    sa.Column("crashes", sa.Integer, nullable=False),  # at the same checkpoint
    sa.Column("crash_step", sa.Integer),  # of that checkpoint
    sa.Column("checkpoint", sa.Integer),  # step of the last one
    sa.Column("fraction", sa.Float),  # of the attempt, 1 for a result
    sa.Column("progress", JSON),
    sa.Column("cause", words(Cause)),
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
    sa.Index("jobs_queue", "state", "priority", "turn", "ordinal"),
)

POINTS = sa.Table(
    "points",
    TABLES,
    sa.Column("sweep_id", sa.ForeignKey("sweeps.id"), primary_key=True),
    sa.Column("ordinal", sa.Integer, primary_key=True),
    sa.Column("run_id", sa.ForeignKey("jobs.id"), nullable=False),
    sa.Column("place", JSON, nullable=False),  # index on each axis
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

# Each start of a dispatcher is an epoch; a claim carries the epoch that it was made in.
DISPATCHERS = sa.Table(
    "dispatchers",
    TABLES,
    sa.Column("epoch", sa.Integer, primary_key=True),
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
    sa.Column("hindrance", sa.Text),
    sa.Column("revivals", sa.Integer, nullable=False),  # points that had ended, and no longer have
    sa.Column("data_id", sa.String(32)),  # of the data directory that belongs to this database
    sa.Column("forgettable", sa.Integer, nullable=False),  # lost results, beyond the limits
)

# How far the queue has come among the runs of one priority: the turn of the last one claimed.
LANES = sa.Table(
    "lanes",
    TABLES,
    sa.Column("priority", sa.Integer, primary_key=True, autoincrement=False),
    sa.Column("turn", sa.Float, nullable=False),
)

KEYS = sa.Table(
    "keys",
    TABLES,
    sa.Column("id", sa.String(32), primary_key=True),
    sa.Column("name", sa.Text, nullable=False),
    sa.Column("prefix", sa.String(16), nullable=False),  # of the secret
    sa.Column("sha256", sa.String(64), nullable=False),  # of the secret
    sa.Column("scopes", sa.Text, nullable=False),  # words with spaces between
    sa.Column("created", UtcTime, nullable=False),
    sa.Column("expires", UtcTime),
    sa.Column("used", UtcTime),
    sa.Column("revoked", UtcTime),
    sa.Index("keys_prefix", "prefix"),
)

# A submission that can be sent again without being accepted twice.
IDEMPOTENCY = sa.Table(
    "idempotency",
    TABLES,
    sa.Column("owner", sa.Text, primary_key=True),
    sa.Column("key", sa.Text, primary_key=True),
    sa.Column("digest", sa.String(64), nullable=False),  # of the body
    sa.Column("sweep_id", sa.ForeignKey("sweeps.id"), nullable=False),
    sa.Index("idempotency_sweep", "sweep_id"),
)

# Attempts without success since the store was made.
CAUSES = sa.Table(
    "causes",
    TABLES,
    sa.Column("cause", words(Cause), primary_key=True),
    sa.Column("attempts", sa.BigInteger, nullable=False),
)
