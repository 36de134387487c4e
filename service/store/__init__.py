"""The only room with a database connection: ``Store`` holds an object for each kind of row.

Each of them has the commands and the queries about its rows, and a query about several kinds is with the one that it
answers for. ``tables`` says what is stored, ``connection`` how writers follow one another, ``transitions`` how a job
moves from state to state. One text serves SQLite and PostgreSQL. Records that go in and out are those of
``service.records.jobs``. Called by queue, API and command line.
"""

from collections.abc import Callable
from contextlib import closing

import sqlalchemy as sa

from service.store.connection import Database
from service.store.events import AuditTrail, Events
from service.store.keys import Keys
from service.store.leadership import Leadership, Terms
from service.store.leases import Leases
from service.store.open_file import DatabaseFileLost
from service.store.publications import Publications
from service.store.queue import Queue
from service.store.renewal import Renewals
from service.store.retention import Retention
from service.store.runs import Runs
from service.store.submission import digest_of
from service.store.sweeps import Sweeps
from service.store.tables import CONTROL

__all__ = ["DatabaseFileLost", "Leadership", "Store", "digest_of"]


class Store:
    """Sweeps, runs, publications, their files and what happened to them, in one database."""

    def __init__(self, database: Database):
        self.database = database
        self.sweeps = Sweeps(database)
        self.runs = Runs(database)
        self.publications = Publications(database)
        self.queue = Queue(database)
        self.leases = Leases(database)
        self.terms = Terms(database)
        self.retention = Retention(database)
        self.renewals = Renewals(database)
        self.events = Events(database)
        self.keys = Keys(database)
        self.audit = AuditTrail(database)

    @classmethod
    def open(cls, url: str, *, migrate: bool = True) -> "Store":
        """Connect, and make the tables or bring them up to date; with ``migrate=False`` only check their revision.

        Raises StoreUnavailable, also for tables of another revision.
        """
        database = Database(url)
        try:
            if migrate:
                database.migrate()
            else:
                database.check_revision()
        except BaseException:
            database.close()
            raise
        return cls(database)

    @staticmethod
    def revision(url: str) -> str | None:
        """The revision of a store's tables, None for an empty database; raises StoreUnavailable."""
        with closing(Database(url)) as database:
            return database.revision()

    @staticmethod
    def check_origin(url: str) -> None:
        """Raise StoreUnavailable for an SQLite file that another version made; to be called before it is locked."""
        Database(url).close()

    def close(self) -> None:
        self.database.close()

    def on_command(self, listener: Callable[[], object]) -> None:
        """Call ``listener`` after each command that is given here and leaves the dispatcher something to do.

        It must be quick.
        """
        self.database.listeners.append(listener)

    def ping(self) -> None:
        """Ask for the right to write, and write nothing; raises StoreUnavailable."""
        with self.database.writing() as connection:
            connection.execute(sa.select(sa.literal(1)))

    def data_id(self) -> str | None:
        """Id that the database shares with its data directory; None before its first use."""
        return self.database.value(sa.select(CONTROL.c.data_id))

    def choose_data_id(self, choose: Callable[[str | None], str | None]) -> str | None:
        """Replace the id by what ``choose`` makes of it, while no other service can; return the new one."""
        with self.database.writing() as connection:
            present = connection.execute(sa.select(CONTROL.c.data_id)).scalar_one()
            chosen = choose(present)
            if chosen != present:
                connection.execute(CONTROL.update().values(data_id=chosen))
        return chosen
