"""Every table. Databases of revisions 0001 to 0004, from before the first release, are refused."""

import sqlalchemy as sa
from alembic import op

revision = "0005"
down_revision = None

MOMENT = sa.DateTime(timezone=True)
WORD = sa.String(16)
ID = sa.String(32)
DIGEST = sa.String(64)


def upgrade() -> None:
    """Make the tables, the row of control and the lane of priority 0."""
    _sweeps()
    _jobs()
    _points()
    _artifacts()
    _events()
    _dispatchers()
    _control()
    _keys()
    _idempotency()
    _causes()


def _sweeps() -> None:
    op.create_table(
        "sweeps",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("id", ID, unique=True, nullable=False),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("title", sa.Text, nullable=False),
        sa.Column("scenario", sa.Text, nullable=False),
        sa.Column("document", sa.JSON, nullable=False),
        sa.Column("digest", DIGEST, nullable=False),
        sa.Column("owner", sa.Text, nullable=False),
        sa.Column("priority", sa.Integer, nullable=False),
        sa.Column("keep", WORD, nullable=False),
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
        sa.Column("id", ID, primary_key=True),
        sa.Column("kind", WORD, nullable=False),
        sa.Column("sweep_id", ID, sa.ForeignKey("sweeps.id"), unique=True),
        sa.Column("witness", sa.Integer),
        sa.Column("scenario", sa.Text),
        sa.Column("spec", sa.JSON),
        sa.Column("state", WORD, nullable=False),
        sa.Column("priority", sa.Integer, nullable=False),
        sa.Column("turn", sa.Float, nullable=False),
        sa.Column("ordinal", sa.Integer, nullable=False),
        sa.Column("keep", WORD, nullable=False),
        sa.Column("cost", sa.Float, nullable=False),
        sa.Column("attempt", sa.Integer, nullable=False),
        sa.Column("epoch", sa.Integer, nullable=False),
        sa.Column("token", WORD),
        sa.Column("crashes", sa.Integer, nullable=False),
        sa.Column("crash_step", sa.Integer),
        sa.Column("checkpoint", sa.Integer),
        sa.Column("fraction", sa.Float),
        sa.Column("progress", sa.JSON),
        sa.Column("cause", WORD),
        sa.Column("failure", sa.Text),
        sa.Column("reason", sa.Text),
        sa.Column("summary", sa.JSON),
        sa.Column("path", sa.Text),
        sa.Column("size", sa.BigInteger),
        sa.Column("sha256", DIGEST),
        sa.Column("seconds", sa.Float),
        sa.Column("created", MOMENT, nullable=False),
        sa.Column("queued", MOMENT, nullable=False),
        sa.Column("started", MOMENT),
        sa.Column("finished", MOMENT),
        sa.Column("abandoned", MOMENT),
    )
    op.create_index("jobs_queue", "jobs", ["state", "priority", "turn", "ordinal"])
    op.create_index("jobs_abandoned", "jobs", ["abandoned"])


def _points() -> None:
    op.create_table(
        "points",
        sa.Column("sweep_id", ID, sa.ForeignKey("sweeps.id"), primary_key=True),
        sa.Column("ordinal", sa.Integer, primary_key=True),
        sa.Column("run_id", ID, sa.ForeignKey("jobs.id"), nullable=False),
        sa.Column("place", sa.JSON, nullable=False),
        sa.Column("coordinates", sa.JSON, nullable=False),
        sa.Column("detached", sa.Boolean, nullable=False),
    )
    op.create_index("points_run", "points", ["run_id", "sweep_id"])


def _artifacts() -> None:
    op.create_table(
        "artifacts",
        sa.Column("job_id", ID, sa.ForeignKey("jobs.id"), primary_key=True),
        sa.Column("name", sa.String(64), primary_key=True),
        sa.Column("path", sa.Text, nullable=False),
        sa.Column("size", sa.BigInteger, nullable=False),
        sa.Column("sha256", DIGEST, nullable=False),
    )


def _events() -> None:
    op.create_table(
        "events",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("time", MOMENT, nullable=False),
        sa.Column("kind", WORD, nullable=False),
        sa.Column("sweep_id", ID),
        sa.Column("job_id", ID),
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


def _control() -> None:
    control = op.create_table(
        "control",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("paused", MOMENT),
        sa.Column("hindrance", sa.Text),
        sa.Column("revivals", sa.Integer, nullable=False),
        sa.Column("data_id", ID),
        sa.Column("forgettable", sa.Integer, nullable=False),
    )
    op.bulk_insert(control, [{"id": 1, "revivals": 0, "forgettable": 0}])
    lanes = op.create_table(
        "lanes",
        sa.Column("priority", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("turn", sa.Float, nullable=False),
    )
    op.bulk_insert(lanes, [{"priority": 0, "turn": 0.0}])


def _keys() -> None:
    op.create_table(
        "keys",
        sa.Column("id", ID, primary_key=True),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("prefix", WORD, nullable=False),
        sa.Column("sha256", DIGEST, nullable=False),
        sa.Column("scopes", sa.Text, nullable=False),
        sa.Column("created", MOMENT, nullable=False),
        sa.Column("expires", MOMENT),
        sa.Column("used", MOMENT),
        sa.Column("revoked", MOMENT),
    )
    op.create_index("keys_prefix", "keys", ["prefix"])


def _idempotency() -> None:
    op.create_table(
        "idempotency",
        sa.Column("owner", sa.Text, primary_key=True),
        sa.Column("key", sa.Text, primary_key=True),
        sa.Column("digest", DIGEST, nullable=False),
        sa.Column("sweep_id", ID, sa.ForeignKey("sweeps.id"), nullable=False),
    )
    op.create_index("idempotency_sweep", "idempotency", ["sweep_id"])


def _causes() -> None:
    op.create_table(
        "causes",
        sa.Column("cause", WORD, primary_key=True),
        sa.Column("attempts", sa.BigInteger, nullable=False),
    )
