"""The tables of ``service/store/tables.py``; databases of earlier revisions are refused."""

revision = "0006"
down_revision = None


def upgrade() -> None:
    """Do nothing: an empty database gets every table at once, see ``Database.migrate``."""
