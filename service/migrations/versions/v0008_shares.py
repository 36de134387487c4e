"""Queues of owners in place of priority classes."""

import sqlalchemy as sa
from alembic import op

revision = "0008"
down_revision = "0007"

# The owner of the most urgent sweep that has the run, as ``fair_queueing`` chooses among those that wait.
OWNERS = """
UPDATE jobs SET owner = coalesce(
    (SELECT sweeps.owner FROM points JOIN sweeps ON sweeps.id = points.sweep_id
     WHERE points.run_id = jobs.id ORDER BY sweeps.priority, sweeps.number LIMIT 1),
    (SELECT sweeps.owner FROM sweeps WHERE sweeps.id = jobs.sweep_id), '')
"""
SHARES = """
INSERT INTO shares SELECT queues.priority, queues.owner, coalesce(priority_classes.virtual_time, 0), 0
FROM (SELECT priority, owner FROM sweeps UNION SELECT priority, owner FROM jobs WHERE kind = 'run') AS queues
LEFT JOIN priority_classes ON priority_classes.priority = queues.priority
"""


def upgrade() -> None:
    """Each owner begins with the virtual time of the class, and none was served before the others."""
    op.add_column("jobs", sa.Column("owner", sa.Text, nullable=False, server_default=""))
    op.create_table(
        "shares",
        sa.Column("priority", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("owner", sa.Text, primary_key=True),
        sa.Column("virtual_time", sa.Float, nullable=False),
        sa.Column("served", sa.Float, nullable=False),
    )
    op.execute(OWNERS)
    op.execute(SHARES)
    op.drop_table("priority_classes")
    op.drop_index("jobs_queue", "jobs")
    op.create_index("jobs_queue", "jobs", ["state", "priority", "owner", "virtual_time", "ordinal"])
