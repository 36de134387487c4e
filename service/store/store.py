"""The store as a whole."""

from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING

import sqlalchemy as sa

from service.store.care import GarbageQueries
from service.store.connection import Database
from service.store.identity import Identity
from service.store.keys import Keys
from service.store.orders import Orders
from service.store.questions import Questions
from service.store.queue import Queue

if TYPE_CHECKING:
    from studies.runs.run import Run


class Store(Orders, Questions, Keys, Queue, GarbageQueries, Identity):
    """Sweeps, runs, publications, their files and what happened to them."""

    @classmethod
    def open(
        cls, url: str, *, cost: Callable[["Run"], float] | None = None, migrate: bool = True
    ) -> "Store":
        """Connect, and make the tables or bring them up to date; with ``migrate=False`` only check them.

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
        """The revision of a store's tables, None where there are none; raises StoreUnavailable."""
        with closing(Database(url)) as database:
            return database.revision()

    def close(self) -> None:
        """Give every connection back."""
        self._database.close()

    def copy_to(self, file: Path) -> None:
        """Copy a store on SQLite, as it is at one moment, to a file that is not there yet."""
        self._database.copy_to(file)

    def ping(self) -> None:
        """Ask for the right to write, and write nothing; raises StoreUnavailable."""
        with self._database.writing() as connection:
            connection.execute(sa.select(sa.literal(1)))


def _estimated_core_seconds(run: "Run") -> float:
    """What the studies expect a run to cost."""
    from studies.runs.run import estimate

    return estimate(run).core_seconds
