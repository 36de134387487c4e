"""The audit trail."""

import sqlalchemy as sa
from alembic import op

revision = "0009"
down_revision = "0008"


def upgrade() -> None:
    """Add the table of orders and refused keys."""
    texts = ("owner", "address", "action", "subject", "outcome")
    op.create_table(
        "audit",
        sa.Column("number", sa.Integer, primary_key=True),
        sa.Column("time", sa.DateTime(timezone=True), nullable=False),
        sa.Column("key_id", sa.String(32)),
        *(sa.Column(name, sa.Text, nullable=False) for name in texts),
        sa.Index("audit_time", "time"),
        sqlite_autoincrement=True,
    )
