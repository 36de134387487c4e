"""How the points of sweeps stand, counted; what can no longer change is counted once."""

from collections.abc import Mapping, Sequence

import sqlalchemy as sa

from service.records.jobs import ACTIVE
from service.store.queries import tallies_of
from service.store.rows import Row

MOST_KNOWN = 10_000  # sweeps whose tallies are remembered


class Tallies:
    """Those of sweeps without an unfinished point are remembered, until something is revived."""

    def __init__(self) -> None:
        self._known: dict[str, tuple[int, list[Row]]] = {}

    def of(self, connection: sa.Connection, rows: Sequence[Row]) -> Mapping[str, list[Row]]:
        """``tallies_of`` sweeps, from rows that tell how much was revived before they were read."""
        found = {row.id: self._remembered(row) for row in rows}
        fresh = tallies_of(connection, [id for id, tallies in found.items() if not tallies])
        if len(self._known) + len(fresh) > MOST_KNOWN:
            self._known.clear()
        for row in rows:
            if row.id in fresh and all(one.point_state not in ACTIVE for one in fresh[row.id]):
                self._known[row.id] = row.revivals, fresh[row.id]
        return {**found, **fresh}

    def _remembered(self, row: Row) -> list[Row]:
        revivals, tallies = self._known.get(row.id, (row.revivals, []))
        return tallies if revivals == row.revivals else []
