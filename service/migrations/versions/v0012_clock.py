"""Jumps of the wall clock; the physics of a sweep, and the sweep with its older results."""

import sqlalchemy as sa
from alembic import op

revision = "0012"
down_revision = "0011"


def upgrade() -> None:
    """Add a column of the queue as a whole, and columns of sweeps."""
    op.add_column("control", sa.Column("clock", sa.JSON))
    op.add_column("sweeps", sa.Column("physics", sa.Integer))
    op.add_column("sweeps", sa.Column("renewed", sa.DateTime(timezone=True)))
    op.add_column("sweeps", sa.Column("older", sa.String(32)))
