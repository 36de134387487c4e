"""The store as a whole."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import sqlalchemy as sa

from service.store.connection import Database
from service.store.keys import Keys
from service.store.leases import Leases
from service.store.retention import RetentionQueries
from service.store.run_queries import RunQueries
from service.store.searches import Searches
from service.store.sweep_queries import SweepQueries
from service.store.tables import CONTROL

if TYPE_CHECKING:
    from studies.runs.run import Run


class Store(Searches, SweepQueries, RunQueries, Keys, Leases, RetentionQueries):
    """Sweeps, runs, publications, their files and what happened to them."""

    @classmethod
    def open(cls, url: str, *, cost: Callable[["Run"], float] | None = None, migrate: bool = True) -> "Store":
        """Connect, and make the tables or bring them up to date; with ``migrate=False`` only check their revision.

        ``cost`` estimates the core seconds of a run; without it ``studies.runs.run.estimate`` does. Raises
        StoreUnavailable, also for tables of another revision.
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
        return cls(database, cost=cost or _estimated_core_seconds)

    @staticmethod
    def revision(url: str) -> str | None:
        """The revision of a store's tables, None for an empty database; raises StoreUnavailable."""
        with closing(Database(url)) as database:
            return database.revision()

    def close(self) -> None:
        """Give every connection back."""
        self._database.close()

    def copy_to(self, file: Path) -> None:
        """Copy a store on SQLite, as it is at one moment, to a new file."""
        self._database.copy_to(file)

    def ping(self) -> None:
        """Ask for the right to write, and write nothing; raises StoreUnavailable."""
        with self._database.writing() as connection:
            connection.execute(sa.select(sa.literal(1)))

    def data_id(self) -> str | None:
        """Id that the database shares with its data directory; None before its first use."""
        with self._database.reading() as connection:
            return connection.execute(sa.select(CONTROL.c.data_id)).scalar_one()

    def choose_data_id(self, choose: Callable[[str | None], str | None]) -> str | None:
        """Replace the id by what ``choose`` makes of it, while no other service can; return the new one."""
        with self._database.writing() as connection:
            present = connection.execute(sa.select(CONTROL.c.data_id)).scalar_one()
            chosen = choose(present)
            if chosen != present:
                connection.execute(CONTROL.update().values(data_id=chosen))
        return chosen


def _estimated_core_seconds(run: "Run") -> float:
    """The estimated core seconds of a run, from the studies."""
    from studies.runs.run import estimate

    return estimate(run).core_seconds
