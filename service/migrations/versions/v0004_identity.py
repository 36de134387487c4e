"""The id of the data directory; lost results that people allow to be forgotten beyond the limits."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    """The first service that starts gives database and directory an id."""
    op.add_column("control", sa.Column("data_id", sa.String(32)))
    forgettable = sa.Column("forgettable", sa.Integer, nullable=False, server_default="0")
    op.add_column("control", forgettable)
