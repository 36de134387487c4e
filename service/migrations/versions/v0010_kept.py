"""Pins of sweeps, and how far the comparison of all files with their digests is."""

import sqlalchemy as sa
from alembic import op

revision = "0010"
down_revision = "0009"


def upgrade() -> None:
    """Add a column of sweeps, and one of the queue as a whole."""
    op.add_column("sweeps", sa.Column("pinned", sa.DateTime(timezone=True)))
    op.add_column("control", sa.Column("scrub", sa.JSON))
