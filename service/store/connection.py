"""Connections and transactions, on SQLite and PostgreSQL."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import sqlalchemy as sa

from service.jobs import StoreUnavailable

BUSY_MILLISECONDS = 10_000  # how long SQLite waits for another writer before it says "locked"


class Database:
    """Where the tables are; every use of it is one short transaction."""

    def __init__(self, url: str):
        self._engine = sa.create_engine(url)
        if self._engine.dialect.name == "sqlite":
            sa.event.listen(self._engine, "connect", _prepare_sqlite)
            sa.event.listen(self._engine, "begin", _begin_sqlite)

    @contextmanager
    def reading(self) -> Iterator[sa.Connection]:
        """A transaction that changes nothing, and sees one moment."""
        with self._transaction(writes=False) as connection:
            yield connection

    @contextmanager
    def writing(self) -> Iterator[sa.Connection]:
        """A transaction that changes all of what it says, or nothing."""
        with self._transaction(writes=True) as connection:
            yield connection

    def migrate(self) -> None:
        """Bring the tables up to date."""
        from alembic import command, config

        with self.writing() as connection:
            steps = config.Config()
            steps.set_main_option("script_location", "service:migrations")
            steps.attributes["connection"] = connection
            command.upgrade(steps, "head")

    def close(self) -> None:
        """Give every connection back."""
        self._engine.dispose()

    @contextmanager
    def _transaction(self, *, writes: bool) -> Iterator[sa.Connection]:
        try:
            with self._engine.connect() as connection:
                connection = connection.execution_options(writes=writes)
                with connection.begin():
                    yield connection
        except sa.exc.OperationalError as error:
            raise StoreUnavailable(f"the database cannot be used now: {error.orig}") from error


def _prepare_sqlite(connection: Any, _record: Any) -> None:
    connection.isolation_level = None  # BEGIN is ours: the driver's own comes too late
    connection.execute(f"PRAGMA busy_timeout={BUSY_MILLISECONDS}")
    connection.execute("PRAGMA journal_mode=WAL")
    connection.execute("PRAGMA synchronous=FULL")
    connection.execute("PRAGMA foreign_keys=ON")


def _begin_sqlite(connection: sa.Connection) -> None:
    """A writer takes the write lock at once: asking later can fail when another was faster."""
    writes = connection.get_execution_options().get("writes", True)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")
