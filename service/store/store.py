"""The store as a whole."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import sqlalchemy as sa

from service.jobs import Schema
from service.store.care import Care
from service.store.connection import Database
from service.store.identity import Identity
from service.store.keys import Keys
from service.store.orders import Orders
from service.store.questions import Questions
from service.store.queue import Queue

if TYPE_CHECKING:
    from studies.run import Run


class Store(Orders, Questions, Keys, Queue, Care, Identity):
    """Sweeps, runs, publications, their files and what happened to them."""

    @classmethod
    def open(
        cls, url: str, *, cost: Callable[["Run"], float] | None = None, migrate: bool = True
    ) -> "Store":
        """Connect, bring the tables up to date unless told not to, and return the store.

        ``cost`` estimates the core seconds of a run; without it ``studies.run.estimate`` does.
        """
        database = Database(url)
        if migrate:
            database.migrate()
        return cls(database, cost=cost or _estimated_core_seconds)

    @staticmethod
    def schema(url: str) -> Schema:
        """Which tables a store has, without changing anything; raises StoreUnavailable."""
        database = Database(url)
        try:
            return database.schema()
        finally:
            database.close()

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
    from studies.run import estimate

    return estimate(run).core_seconds
