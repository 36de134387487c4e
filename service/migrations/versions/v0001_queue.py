"""Sweeps, the queue of runs and publications, points, files, events."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None

MOMENT = sa.DateTime(timezone=True)
WORD = sa.String(16)


def upgrade() -> None:
    """Make the first tables."""
    _sweeps()
    _jobs()
    _points()
    _artifacts()
    _events()
    _dispatchers()


def _sweeps() -> None:
    op.create_table(
        "sweeps",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("id", sa.String(32), unique=True, nullable=False),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("title", sa.Text, nullable=False),
        sa.Column("scenario", sa.Text, nullable=False),
        sa.Column("document", sa.JSON, nullable=False),
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("planned", sa.Integer, nullable=False),
        sa.Column("new", sa.Integer, nullable=False),
        sa.Column("created", MOMENT, nullable=False),
        sa.Column("cancelled", MOMENT),
        sqlite_autoincrement=True,
    )
    op.create_index("sweeps_digest", "sweeps", ["digest"])


def _jobs() -> None:
    op.create_table(
        "jobs",
        sa.Column("id", sa.String(32), primary_key=True),
        sa.Column("kind", WORD, nullable=False),
        sa.Column("sweep_id", sa.String(32), sa.ForeignKey("sweeps.id"), unique=True),
        sa.Column("scenario", sa.Text),
        sa.Column("spec", sa.JSON),
        sa.Column("state", WORD, nullable=False),
        sa.Column("priority", sa.Integer, nullable=False),
        sa.Column("ordinal", sa.Integer, nullable=False),
        sa.Column("cost", sa.Float, nullable=False),
        sa.Column("attempt", sa.Integer, nullable=False),
        sa.Column("epoch", sa.Integer, nullable=False),
        sa.Column("token", sa.String(16)),
        sa.Column("crashes", sa.Integer, nullable=False),
        sa.Column("fraction", sa.Float),
        sa.Column("progress", sa.JSON),
        sa.Column("cause", WORD),
        sa.Column("failure", sa.Text),
        sa.Column("reason", sa.Text),
        sa.Column("summary", sa.JSON),
        sa.Column("path", sa.Text),
        sa.Column("size", sa.BigInteger),
        sa.Column("sha256", sa.String(64)),
        sa.Column("seconds", sa.Float),
        sa.Column("created", MOMENT, nullable=False),
        sa.Column("queued", MOMENT, nullable=False),
        sa.Column("started", MOMENT),
        sa.Column("finished", MOMENT),
    )
    op.create_index("jobs_queue", "jobs", ["state", "priority", "queued", "ordinal"])


def _points() -> None:
    op.create_table(
        "points",
        sa.Column("sweep_id", sa.String(32), sa.ForeignKey("sweeps.id"), primary_key=True),
        sa.Column("ordinal", sa.Integer, primary_key=True),
        sa.Column("run_id", sa.String(32), sa.ForeignKey("jobs.id"), nullable=False),
        sa.Column("place", sa.JSON, nullable=False),
        sa.Column("coordinates", sa.JSON, nullable=False),
        sa.Column("detached", sa.Boolean, nullable=False),
    )
    op.create_index("points_run", "points", ["run_id", "sweep_id"])


def _artifacts() -> None:
    op.create_table(
        "artifacts",
        sa.Column("sweep_id", sa.String(32), sa.ForeignKey("sweeps.id"), primary_key=True),
        sa.Column("name", sa.String(64), primary_key=True),
        sa.Column("path", sa.Text, nullable=False),
        sa.Column("size", sa.BigInteger, nullable=False),
        sa.Column("sha256", sa.String(64), nullable=False),
    )


def _events() -> None:
    op.create_table(
        "events",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("time", MOMENT, nullable=False),
        sa.Column("kind", WORD, nullable=False),
        sa.Column("sweep_id", sa.String(32)),
        sa.Column("job_id", sa.String(32)),
        sa.Column("body", sa.JSON, nullable=False),
        sqlite_autoincrement=True,
    )
    op.create_index("events_sweep", "events", ["sweep_id", "number"])
    op.create_index("events_job", "events", ["job_id", "number"])


def _dispatchers() -> None:
    op.create_table(
        "dispatchers",
        sa.Column("epoch", sa.Integer, primary_key=True),
        sa.Column("owner", sa.Text, nullable=False),
        sa.Column("started", MOMENT, nullable=False),
        sqlite_autoincrement=True,
    )
