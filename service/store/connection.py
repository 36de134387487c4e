"""Connections and transactions, on SQLite and PostgreSQL.

Writers run one at a time, on both. SQLite knows nothing else; on PostgreSQL every writer first locks the one row of
``control``, and reads only after that: each of its statements then sees all that earlier writers committed (READ
COMMITTED), and nothing changes between its statements. So whatever holds for one order of the transactions holds for
any number of replicas: two of them that accept the same sweep, a run that ends while a sweep joins it, a cancel beside
a submission. No writer holds another lock while it waits for this one, so there are no deadlocks and no failures to
serialise, and the numbers of events become visible in order. The price: replicas do not write side by side.

Readers wait for no writer, and see one moment (REPEATABLE READ, a read transaction of SQLite).
"""

import json
import sqlite3
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import sqlalchemy as sa

from service.records.jobs import StoreDamaged, StoreUnavailable
from service.store.open_file import DatabaseFileLost, OpenFile
from service.store.tables import CONTROL, REVISION, REVISIONS, TABLES, Query, StatementRow, one_row

if TYPE_CHECKING:
    from alembic.config import Config  # alembic takes 0.3 s, which the usual start need not wait for
    from sqlalchemy.pool import ConnectionPoolEntry

    from studies.quantities.parameters import Plain

Value = TypeVar("Value")

BUSY_MILLISECONDS = 20_000  # wait of a writer for others before it raises StoreUnavailable
NO_WAIT_MILLISECONDS = 100  # a shorter wait within the process is not worth another statement


class JsonText(str):
    """A value of a JSON column that is written already."""

    __slots__ = ()


def _as_json(value: "Plain | JsonText") -> str:
    return value if isinstance(value, JsonText) else json.dumps(value)


# With the 2 MiB of SQLite's own, a writer of 10 000 rows reads its unfinished work back from the file:
# 1.2 s instead of 0.06 s for an update of them (2026-11).
CACHE_KIBIBYTES = 32 * 1024
# Of all connections of a process: a dozen readers would keep 32 MiB each.
MOST_CACHED = 40 << 20  # bytes
PRIVATE = 0o600  # digests of keys are in the database
MIGRATION_LOCK = int.from_bytes(b"migrate")  # advisory, of PostgreSQL

POSTGRESQL = {
    # A client that is gone must not keep its locks. A cut network is detected after 5 + 3 * 2 s, a process
    # that is frozen within a transaction before another service has come to lead.
    "tcp_keepalives_idle": "5",
    "tcp_keepalives_interval": "2",
    "tcp_keepalives_count": "3",
    "idle_in_transaction_session_timeout": "8s",
    # A row of an index costs about the same as the next one of its table: the tables are in memory or
    # on a disk without a head. With PostgreSQL's own 4 a page of 100 points read all 10 000 runs, in
    # 3.6 ms instead of 0.25 (2026-11).
    "random_page_cost": "1.1",
}


class Database:
    """A database; every use of it is one short transaction.

    Raises StoreUnavailable, before anything is opened or locked, for an SQLite file of an unknown revision.
    """

    def __init__(self, url: str, migrations: str = "service:migrations", revision: str = REVISION):
        self.url = sa.make_url(url)
        self._migrations = migrations
        self._newest = revision
        self._mutex = threading.Lock()  # writers of this process wait without a connection
        self.listeners: list[Callable[[], object]] = []  # called after each command
        self._file: OpenFile | None = None
        is_file = self.is_sqlite and self.url.database not in (None, "", ":memory:")
        self._path = Path(str(self.url.database)) if is_file else None
        present = None if self._path is None else _revision_of(self._path)
        if present not in (None, revision) and present not in self._revisions():
            raise self._refusal(present)
        self._engine = sa.create_engine(
            self.url,
            json_serializer=_as_json,
            pool_size=10,
            max_overflow=20,
            pool_timeout=BUSY_MILLISECONDS / 1000,
            pool_pre_ping=not self.is_sqlite,
            connect_args={} if self.is_sqlite else limits_of_postgresql(),
        )
        if self.is_sqlite:
            self._readers = self._engine.execution_options(writes=False)
            if self._path is not None:
                self._file = _watched(self._engine, OpenFile(self._path))
            sa.event.listen(self._engine, "connect", _prepare_sqlite)
            sa.event.listen(self._engine, "begin", _begin_sqlite)
        else:
            self._readers = self._engine.execution_options(isolation_level="REPEATABLE READ", postgresql_readonly=True)

    @property
    def is_sqlite(self) -> bool:
        return self.url.get_backend_name() == "sqlite"

    @contextmanager
    def reading(self) -> Iterator[sa.Connection]:
        """A read transaction, which sees one moment."""
        self._check_file()
        with _transaction(self._readers) as connection:
            yield connection

    def rows(self, query: Query) -> Sequence[StatementRow]:
        """All rows of a query, in a read transaction of its own."""
        with self.reading() as connection:
            return connection.execute(query).all()

    def row(self, query: Query, kind: str, id: str) -> StatementRow:
        """The single row of a query, in a read transaction of its own; raises NotFound."""
        with self.reading() as connection:
            return one_row(connection, query, kind, id)

    def value(self, query: sa.Select[Value]) -> Value:
        """The only value of a query, in a read transaction of its own."""
        with self.reading() as connection:
            return connection.execute(query).scalar_one()

    @contextmanager
    def writing(self) -> Iterator[sa.Connection]:
        """A write transaction; no other one runs meanwhile.

        Raises DatabaseFileLost, also after the commit: what is written to a file that is gone is not stored.
        """
        with self._alone() as left:
            self._check_file()
            engine = self._engine.execution_options(lock_milliseconds=left)
            with _transaction(engine) as connection:
                if not self.is_sqlite and left < BUSY_MILLISECONDS - NO_WAIT_MILLISECONDS:
                    connection.exec_driver_sql(f"SET LOCAL lock_timeout = {left}")
                connection.execute(sa.select(CONTROL.c.id).with_for_update())
                yield connection
            self._check_file()

    @contextmanager
    def commanding(self) -> Iterator[sa.Connection]:
        """A write transaction that leaves the dispatcher something to do."""
        with self.writing() as connection:
            yield connection
        for listener in self.listeners:
            listener()

    def migrate(self) -> None:
        """Make the tables in an empty database, or bring them up to date; raises StoreUnavailable.

        Tables of an unknown revision are refused.
        """
        if self._path is not None:
            _make_private(self._path)
        if self.revision() == self._newest:
            return
        with self._alone(), _transaction(self._engine) as connection:
            if not self.is_sqlite:
                connection.execute(sa.select(sa.func.pg_advisory_xact_lock(MIGRATION_LOCK)))
            present = _revision(connection)
            if present is None:
                TABLES.create_all(connection)
                REVISIONS.create(connection)
                connection.execute(CONTROL.insert().values(cache_generation=0, forgettable=0))
                connection.execute(REVISIONS.insert().values(version_num=self._newest))
            elif present in self._revisions():
                from alembic import command

                migrations = self._alembic()
                migrations.attributes["connection"] = connection
                command.upgrade(migrations, "head")
            else:
                raise self._refusal(present)

    def check_revision(self) -> None:
        """Raise StoreUnavailable unless the tables are those of this version."""
        present = self.revision()
        if present != self._newest:
            raise self._refusal(present)

    def revision(self) -> str | None:
        """The revision of the tables; None for an empty database."""
        with self.reading() as connection:
            return _revision(connection)

    def _revisions(self) -> list[str]:
        """The revisions that this version knows, the newest first."""
        from alembic.script import ScriptDirectory

        scripts = ScriptDirectory.from_config(self._alembic())
        return [script.revision for script in scripts.walk_revisions()]

    def _refusal(self, present: str | None) -> StoreUnavailable:
        place = self.url.database if self.is_sqlite else self.url.render_as_string()
        problem = f"{place} has tables of revision {present}, and this version needs {self._newest}"
        if present in (None, *self._revisions()):
            return StoreUnavailable(f"{problem}: start the service, which updates the tables")
        cure = "keep it with its data directory, and start with a new data directory and database"
        return StoreUnavailable(f"{problem}; nothing was changed: {cure}; whipple.open_cube still reads its cubes")

    def _alembic(self) -> "Config":
        from alembic import config

        migrations = config.Config()
        migrations.set_main_option("script_location", self._migrations)
        return migrations

    def check_pages(self) -> None:
        """Read every page of an SQLite file; raises StoreDamaged. A server checks its own."""
        if self.is_sqlite:
            with self.reading() as connection:
                problem = connection.exec_driver_sql("PRAGMA quick_check(1)").scalar()
            if problem != "ok":
                raise StoreDamaged(f"the database is damaged: {problem}")

    def copy_to(self, file: Path) -> None:
        """Copy an SQLite file, as it is at one moment; writers go on meanwhile."""
        assert self.is_sqlite
        file.touch(PRIVATE)
        try:
            with closing(self._engine.raw_connection()) as connection:
                connection.cursor().execute("VACUUM INTO ?", (str(file),))
        except sqlite3.OperationalError as error:  # locked, or no space
            raise StoreUnavailable(f"the database cannot be copied now: {error}") from error

    def close(self) -> None:
        self._engine.dispose()

    def _check_file(self) -> None:
        if self._file is not None:
            self._file.check()

    @contextmanager
    def _alone(self) -> Iterator[int]:
        """Be the only writer of this process; yields the milliseconds left to wait for other processes."""
        begin = time.monotonic()
        if not self._mutex.acquire(timeout=BUSY_MILLISECONDS / 1000):
            raise StoreUnavailable("the database cannot be used now: locked by another writer")
        try:
            waited = int(1000 * (time.monotonic() - begin))
            yield max(BUSY_MILLISECONDS - waited, 1)
        finally:
            self._mutex.release()


class Repository:
    """The commands and queries about one kind of rows: each a transaction, of a few statements whatever the size."""

    def __init__(self, database: Database):
        self._database = database


def _watched(engine: sa.Engine, file: OpenFile) -> OpenFile:
    """Let each connection of an engine be noted, and refused if it is to another file."""

    def add(connection: sqlite3.Connection, _record: "ConnectionPoolEntry") -> None:
        try:
            file.add_connection()
        except DatabaseFileLost:
            connection.close()
            raise

    sa.event.listen(engine, "connect", add)
    sa.event.listen(engine, "close", lambda _connection, _record: file.remove_connection())
    return file


def _make_private(database: Path) -> None:
    """Make the file of a database if it is missing, and take it and what SQLite writes beside it from other users."""
    try:
        database.touch(PRIVATE)
    except OSError as error:
        raise StoreUnavailable(f"{database} cannot be used: {error.strerror}") from None
    for end in ("", "-wal", "-shm"):
        with suppress(OSError):  # not there, or another user's
            Path(f"{database}{end}").chmod(PRIVATE)


def limits_of_postgresql(idle_session_timeout: str = "0") -> dict[str, str | int]:
    """Arguments of the driver that give every wait of a connection a time limit.

    The server ends connections that are idle for longer than ``idle_session_timeout``; 0: never.
    """
    settings = POSTGRESQL | {"lock_timeout": str(BUSY_MILLISECONDS), "idle_session_timeout": idle_session_timeout}
    return {
        "options": " ".join(f"-c {name}={value}" for name, value in settings.items()),
        "connect_timeout": 10,
        "keepalives_idle": 5,
        "keepalives_interval": 2,
        "keepalives_count": 3,
        "tcp_user_timeout": BUSY_MILLISECONDS,
    }


@contextmanager
def _transaction(engine: sa.Engine) -> Iterator[sa.Connection]:
    try:
        with engine.connect() as connection, connection.begin():
            yield connection
    except sa.exc.DBAPIError as error:
        # SQLite raises a plain DatabaseError for a file that is damaged, or no database.
        is_damaged = type(error) is sa.exc.DatabaseError
        is_away = isinstance(error, sa.exc.OperationalError) or error.connection_invalidated
        if is_damaged:
            raise StoreDamaged(f"the database is damaged: {error.orig}") from error
        if is_away:
            raise StoreUnavailable(f"the database cannot be used now: {error.orig}") from error
        raise
    except sa.exc.TimeoutError as error:  # of the pool
        raise StoreUnavailable(f"the database cannot be used now: {error}") from error


def _revision(connection: sa.Connection) -> str | None:
    if not sa.inspect(connection).has_table(REVISIONS.name):
        return None
    return connection.scalar(sa.select(REVISIONS.c.version_num))


def _revision_of(file: Path) -> str | None:
    """The revision of the tables in an SQLite file, which is only read; None where it has none, or is being written.

    First without the log beside it, which any other connection may write into the file; a log may have the only tables.
    """
    for how in ("mode=ro&immutable=1", "mode=ro"):
        address = f"{file.absolute().as_uri()}?{how}"
        with suppress(sqlite3.Error), closing(sqlite3.connect(address, uri=True)) as connection:
            for (revision,) in connection.execute(f"SELECT version_num FROM {REVISIONS.name}"):
                return str(revision)
    return None


def _prepare_sqlite(connection: sqlite3.Connection, _record: "ConnectionPoolEntry") -> None:
    connection.isolation_level = None  # ``_begin_sqlite`` begins: the driver would do so too late
    for name, value in (
        ("busy_timeout", BUSY_MILLISECONDS),
        ("journal_mode", "WAL"),
        ("synchronous", "FULL"),
        ("foreign_keys", "ON"),
        ("cache_size", -CACHE_KIBIBYTES),
        ("soft_heap_limit", MOST_CACHED),
    ):
        connection.execute(f"PRAGMA {name}={value}")


def _begin_sqlite(connection: sa.Connection) -> None:
    """Begin; a writer takes the write lock at once, since a later upgrade can fail."""
    options = connection.get_execution_options()
    if "lock_milliseconds" in options:
        timeout = f"PRAGMA busy_timeout={options['lock_milliseconds']}"
        connection.connection.cursor().execute(timeout)
    writes = options.get("writes", True)
    connection.exec_driver_sql("BEGIN IMMEDIATE" if writes else "BEGIN")
