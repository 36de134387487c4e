"""Sums by owner and of results, runs that belong to a sweep that is there, and indexes of what has not ended."""

import sqlalchemy as sa
from alembic import op

revision = "0011"
down_revision = "0010"

# A run is abandoned once no sweep has it; one that a sweep has belongs to the owner of such a sweep.
OWNERS = """
UPDATE jobs SET abandoned = NULL, owner = coalesce(
    (SELECT sweeps.owner FROM points JOIN sweeps ON sweeps.id = points.sweep_id
     WHERE points.run_id = jobs.id AND sweeps.owner = jobs.owner LIMIT 1),
    (SELECT sweeps.owner FROM points JOIN sweeps ON sweeps.id = points.sweep_id
     WHERE points.run_id = jobs.id ORDER BY sweeps.number LIMIT 1), owner)
WHERE abandoned IS NOT NULL AND EXISTS (SELECT 1 FROM points WHERE points.run_id = jobs.id)
"""
EDGES = (1, 3, 10, 30, 100, 300, 1000, 3000, 10_000, 30_000, 100_000, 300_000)  # seconds
BUCKET = " + ".join(f"CASE WHEN seconds > {edge} THEN 1 ELSE 0 END" for edge in EDGES)
RESULTS = f"""
INSERT INTO results (scenario, succeeded, bucket, attempts, seconds, cost)
SELECT scenario, succeeded, bucket, count(*), sum(seconds), sum(cost)
FROM (SELECT scenario, state = 'succeeded' AS succeeded, {BUCKET} AS bucket, seconds, cost FROM jobs
      WHERE kind = 'run' AND state IN ('succeeded', 'failed') AND path IS NOT NULL AND seconds IS NOT NULL) AS ended
GROUP BY scenario, succeeded, bucket
"""
ACTIVE = "state IN ('waiting', 'queued', 'running', 'cancelling')"
INDEXES = {
    "jobs_queue": (["priority", "owner", "virtual_time", "ordinal"], "state = 'queued'"),
    "jobs_active": (["state", "kind", "owner", "queued"], ACTIVE),
    "jobs_abandoned": (["abandoned"], "abandoned IS NOT NULL"),
    "jobs_published": (["finished"], "sweep_id IS NOT NULL"),
}


def upgrade() -> None:
    """Fill the sums from the rows; ``owned_bytes`` is filled with the triggers that keep it."""
    op.execute(OWNERS)
    op.create_table(
        "results",
        sa.Column("scenario", sa.Text, primary_key=True),
        sa.Column("succeeded", sa.Boolean, primary_key=True),
        sa.Column("bucket", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("attempts", sa.BigInteger, nullable=False),
        sa.Column("seconds", sa.Float, nullable=False),
        sa.Column("cost", sa.Float, nullable=False),
    )
    op.create_table(
        "owned_bytes", sa.Column("owner", sa.Text, primary_key=True), sa.Column("bytes", sa.BigInteger, nullable=False)
    )
    op.execute(RESULTS)
    for name in ("jobs_queue", "jobs_abandoned"):
        op.drop_index(name, "jobs")
    op.create_index("jobs_states", "jobs", ["state", "kind"])
    for name, (columns, where) in INDEXES.items():
        op.create_index(name, "jobs", columns, sqlite_where=sa.text(where), postgresql_where=sa.text(where))
