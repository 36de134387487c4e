"""Who works through the queue: one service at a time.

With SQLite it is whoever holds the data directory; that lock is taken before the store is opened.
With PostgreSQL every service is a replica, and the one leads whose connection holds an advisory lock
of the database. The server gives the lock back when that connection ends, however it ends; no clock
is asked. It ends the connection of a leader that is silent for ``IDLE_SECONDS``: its process is frozen,
or its network cut. A leader that lost its connection learns it from ``holds``; what it writes until
then is fenced by its epoch.
"""

import threading
from typing import Any

import sqlalchemy as sa

from service.records.jobs import StoreUnavailable
from service.store.connection import Database, connect_postgresql
from service.store.tables import DISPATCHERS

LOCK = int.from_bytes(b"leader")  # advisory, of PostgreSQL
IDLE_SECONDS = 6.0  # of silence, after which the server ends the connection that holds the lock
PING_SECONDS = 1.5  # between two words to the server: four of them fit into its patience


class Leadership:
    """The right to work through the queue, while it lasts."""

    def __init__(self, connection: sa.Connection | None = None):
        self._connection = connection  # None: somebody else sees to it that there is one leader
        self._mutex = threading.Lock()  # of the connection
        self._closing = threading.Event()
        if connection is not None:  # a turn may take longer than the server's patience
            threading.Thread(target=self._ping, name="leadership", daemon=True).start()

    def holds(self) -> bool:
        """Whether the right is still there; asks the server."""
        if self._connection is None:
            return True
        try:
            with self._mutex:
                return self._connection.execute(_is_own()).scalar() is not None
        except sa.exc.SQLAlchemyError:
            return False

    def close(self) -> None:
        """Give the right back; others may take it at once."""
        self._closing.set()
        if self._connection is not None:
            with self._mutex:
                self._connection.close()

    def _ping(self) -> None:
        """Say something to the server every so often, until the right is given back or lost."""
        while not self._closing.wait(PING_SECONDS) and self.holds():
            pass


def lead(database: Database, owner: str) -> Leadership | None:
    """Become the leader, or None if another service is; raises StoreUnavailable."""
    if database.is_sqlite:
        return Leadership()
    engine = connect_postgresql(
        database.url,
        idle_session_timeout=f"{IDLE_SECONDS:g}s",
        poolclass=sa.NullPool,
        isolation_level="AUTOCOMMIT",
    )
    try:
        connection = engine.connect()
        named = sa.func.set_config("application_name", owner, False)
        taken = connection.execute(sa.select(named, sa.func.pg_try_advisory_lock(LOCK))).one()[1]
    except sa.exc.OperationalError as error:
        raise StoreUnavailable(f"the database cannot be used now: {error.orig}") from error
    if taken:
        return Leadership(connection)
    connection.close()
    return None


def leader(database: Database, connection: sa.Connection) -> str | None:
    """Who leads now; on SQLite, who did last."""
    if not database.is_sqlite:
        return connection.execute(_held("application_name")).scalar()
    youngest = sa.select(DISPATCHERS.c.owner).order_by(DISPATCHERS.c.epoch.desc()).limit(1)
    return connection.execute(youngest).scalar()


def _is_own() -> sa.Select[Any]:
    own = sa.literal_column("activity.pid") == sa.func.pg_backend_pid()
    return _held("pid").where(own)


def _held(column: str) -> sa.Select[Any]:
    """A column of the session that holds the lock of this database."""
    sessions = sa.text(
        "pg_locks AS lock JOIN pg_stat_activity AS activity ON activity.pid = lock.pid "
        "JOIN pg_database AS here ON here.oid = lock.database AND here.datname = current_database()"
    )
    return (
        sa.select(sa.literal_column(f"activity.{column}"))
        .select_from(sessions)
        .where(sa.text("lock.locktype = 'advisory' AND lock.granted AND lock.objsubid = 1"))
        .where(sa.text(f"lock.classid = {LOCK >> 32} AND lock.objid = {LOCK & 0xFFFFFFFF}"))
    )
