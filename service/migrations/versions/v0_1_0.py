"""The tables of ``service/store/tables.py`` in version 0.1.0; databases of before are refused."""

revision = "0.1.0.2"
down_revision = None


def upgrade() -> None:
    """Do nothing: an empty database gets every table at once, see ``Database.migrate``."""
