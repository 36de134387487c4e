"""Owners, priorities and retention of sweeps; turns and checkpoints of runs; files of runs; keys."""

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"

MOMENT = sa.DateTime(timezone=True)
WORD = sa.String(16)


def upgrade() -> None:
    """Add what is new; everything that was accepted stays, with the values that it had unsaid."""
    _sweeps()
    _jobs()
    _artifacts()
    _control()
    _keys()
    _idempotency()
    _causes()


def _sweeps() -> None:
    op.add_column("sweeps", sa.Column("owner", sa.Text, nullable=False, server_default=""))
    op.add_column("sweeps", sa.Column("priority", sa.Integer, nullable=False, server_default="0"))
    op.add_column("sweeps", sa.Column("keep", WORD, nullable=False, server_default="final"))


def _jobs() -> None:
    op.drop_index("jobs_queue", "jobs")
    op.add_column("jobs", sa.Column("turn", sa.Float, nullable=False, server_default="0"))
    op.add_column("jobs", sa.Column("keep", WORD, nullable=False, server_default="final"))
    op.add_column("jobs", sa.Column("witness", sa.Integer))
    op.add_column("jobs", sa.Column("crash_step", sa.Integer))
    op.add_column("jobs", sa.Column("checkpoint", sa.Integer))
    op.execute("UPDATE jobs SET priority = -1000 WHERE kind = 'publish'")
    # Runs of one sweep were queued at one moment: its turns begin at zero.
    op.execute(
        "UPDATE jobs SET turn = ahead.cost FROM (SELECT id, "
        "sum(cost) OVER (PARTITION BY queued ORDER BY ordinal) - cost AS cost "
        "FROM jobs WHERE kind = 'run' AND state = 'queued') AS ahead WHERE ahead.id = jobs.id"
    )
    op.create_index("jobs_queue", "jobs", ["state", "priority", "turn", "ordinal"])


def _artifacts() -> None:
    """Files belong to jobs: those of a sweep to its publication, results to their runs."""
    op.rename_table("artifacts", "artifacts_of_sweeps")
    op.create_table(
        "artifacts",
        sa.Column("job_id", sa.String(32), sa.ForeignKey("jobs.id"), primary_key=True),
        sa.Column("name", sa.String(64), primary_key=True),
        sa.Column("path", sa.Text, nullable=False),
        sa.Column("size", sa.BigInteger, nullable=False),
        sa.Column("sha256", sa.String(64), nullable=False),
    )
    op.execute(
        "INSERT INTO artifacts (job_id, name, path, size, sha256) "
        "SELECT jobs.id, old.name, old.path, old.size, old.sha256 "
        "FROM artifacts_of_sweeps AS old JOIN jobs ON jobs.sweep_id = old.sweep_id"
    )
    op.execute(
        "INSERT INTO artifacts (job_id, name, path, size, sha256) "
        "SELECT id, 'result.json', path, size, sha256 FROM jobs "
        "WHERE kind = 'run' AND path IS NOT NULL"
    )
    op.drop_table("artifacts_of_sweeps")


def _control() -> None:
    control = op.create_table(
        "control",
        sa.Column("id", sa.Integer, primary_key=True),
        sa.Column("paused", MOMENT),
        sa.Column("hindrance", sa.Text),
    )
    op.bulk_insert(control, [{"id": 1}])
    lanes = op.create_table(
        "lanes",
        sa.Column("priority", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("turn", sa.Float, nullable=False),
    )
    op.bulk_insert(lanes, [{"priority": 0, "turn": 0.0}])


def _keys() -> None:
    op.create_table(
        "keys",
        sa.Column("id", sa.String(32), primary_key=True),
        sa.Column("name", sa.Text, nullable=False),
        sa.Column("prefix", sa.String(16), nullable=False),
        sa.Column("sha256", sa.String(64), nullable=False),
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
        sa.Column("digest", sa.String(64), nullable=False),
        sa.Column("sweep_id", sa.String(32), sa.ForeignKey("sweeps.id"), nullable=False),
    )
    op.create_index("idempotency_sweep", "idempotency", ["sweep_id"])


def _causes() -> None:
    op.create_table(
        "causes",
        sa.Column("cause", WORD, primary_key=True),
        sa.Column("attempts", sa.BigInteger, nullable=False),
    )
