"""When a run was let go of by a sweep that was deleted; how often ended runs were queued again."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"

MOMENT = sa.DateTime(timezone=True)


def upgrade() -> None:
    """Runs that no sweep has by now are let go of today."""
    op.add_column("control", sa.Column("revivals", sa.Integer, nullable=False, server_default="0"))
    op.add_column("jobs", sa.Column("abandoned", MOMENT))
    op.create_index("jobs_abandoned", "jobs", ["abandoned"])
    op.execute(
        "UPDATE jobs SET abandoned = CURRENT_TIMESTAMP WHERE kind = 'run' "
        "AND NOT EXISTS (SELECT 1 FROM points WHERE points.run_id = jobs.id)"
    )
