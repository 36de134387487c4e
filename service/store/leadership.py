"""Leadership: one service at a time works through the queue.

With SQLite it is the service that holds the lock of the data directory, taken before the store is
opened. With PostgreSQL every service is a replica, and the leader is the one whose connection holds an
advisory lock of the database. The server releases the lock when that connection ends, whatever ends
it, and it ends the connection of a leader that is silent for ``IDLE_SECONDS``: its process is frozen, or
its network cut. A leader learns of the loss from ``holds``; its writes until then are fenced by its term.
"""

import threading

import sqlalchemy as sa

from service.records.jobs import StoreUnavailable
from service.store.connection import Database, Repository, limits_of_postgresql
from service.store.tables import TERMS, now

LOCK = int.from_bytes(b"leader")  # advisory, of PostgreSQL
IDLE_SECONDS = 6.0  # of silence, after which the server ends the connection that holds the lock
PING_SECONDS = 1.5  # interval between two pings of the server: four of them fit into IDLE_SECONDS


class Leadership:
    """The right to work through the queue, until it is given back or lost."""

    def __init__(self, connection: sa.Connection | None = None):
        self._connection = connection  # None: the lock of the data directory makes sure of one leader
        self._mutex = threading.Lock()  # of the connection
        self._closing = threading.Event()
        if connection is not None:  # a tick may take longer than IDLE_SECONDS
            threading.Thread(target=self._ping, name="leadership", daemon=True).start()

    def holds(self) -> bool:
        """Whether the right is still there; a query of the server."""
        if self._connection is None:
            return True
        own = _held("pid").where(sa.literal_column("activity.pid") == sa.func.pg_backend_pid())
        try:
            with self._mutex:
                return self._connection.execute(own).scalar() is not None
        except sa.exc.SQLAlchemyError:
            return False

    def close(self) -> None:
        """Give the right back; another service may take it at once."""
        self._closing.set()
        if self._connection is not None:
            with self._mutex:
                self._connection.close()

    def _ping(self) -> None:
        """Query the server every PING_SECONDS, until the right is given back or lost."""
        while not self._closing.wait(PING_SECONDS) and self.holds():
            pass


class Terms(Repository):
    """Terms of leadership: a lease carries the number of the one that it was given in."""

    def lead(self, owner: str) -> Leadership | None:
        """Become the service that works through the queue; None: another one is. Raises StoreUnavailable."""
        if self._database.is_sqlite:
            return Leadership()
        limits = limits_of_postgresql(idle_session_timeout=f"{IDLE_SECONDS:g}s")
        engine = sa.create_engine(
            self._database.url, poolclass=sa.NullPool, isolation_level="AUTOCOMMIT", connect_args=limits
        )
        try:
            connection = engine.connect()
            named = sa.func.set_config("application_name", owner, False)
            leads = connection.execute(sa.select(named, sa.func.pg_try_advisory_lock(LOCK))).one()[1]
        except sa.exc.OperationalError as error:
            raise StoreUnavailable(f"the database cannot be used now: {error.orig}") from error
        if leads:
            return Leadership(connection)
        connection.close()
        return None

    def begin(self, owner: str) -> int:
        """Number of a new term; no lease is given in earlier ones any more."""
        begin = TERMS.insert().values(owner=owner, started=now())
        with self._database.writing() as connection:
            return connection.execute(begin.returning(TERMS.c.term)).scalar_one()

    def latest(self) -> int:
        """Number of the latest term that has begun."""
        return self._database.value(sa.select(sa.func.max(TERMS.c.term)))


def leader(database: Database) -> sa.Select[str]:
    """A query of the owner of the present term; on SQLite, of the last one."""
    if not database.is_sqlite:
        return _held("application_name")
    return sa.select(TERMS.c.owner).order_by(TERMS.c.term.desc()).limit(1)


def _held(column: str) -> sa.Select[str]:
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
