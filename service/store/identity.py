"""The id that the database shares with its data directory."""

from collections.abc import Callable

import sqlalchemy as sa

from service.store.connection import Part
from service.store.tables import CONTROL


class Identity(Part):
    """One id, which the first service that uses the database gives it."""

    def data_id(self) -> str | None:
        """The id of the data directory that belongs to this database; None: it has none yet."""
        with self._database.reading() as connection:
            return connection.execute(sa.select(CONTROL.c.data_id)).scalar_one()

    def choose_data_id(self, choose: Callable[[str | None], str | None]) -> str | None:
        """Let ``choose`` make the id out of the one that is there; no other service does so meanwhile."""
        with self._database.writing() as connection:
            known = connection.execute(sa.select(CONTROL.c.data_id)).scalar_one()
            chosen = choose(known)
            if chosen != known:
                connection.execute(CONTROL.update().values(data_id=chosen))
        return chosen
