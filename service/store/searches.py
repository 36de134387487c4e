"""Sweeps that search for a limit: their publication waits for further runs, which follow from the results so far.

The row of the publication is that of the search: it is leased when all runs have ended, and goes back to waiting where
the results ask for further ones. Nothing is stored beyond the document and the results, so that restart, cancel and
retry are those of any sweep.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import sqlalchemy as sa

from service.records.expansion import expanded_points
from service.records.jobs import Lease, State
from service.store import fair_queueing
from service.store.commands import Commands, insert_new_runs, insert_points, run_rows
from service.store.statements import invalidate_tallies, is_held, log_event, now, release_publications
from service.store.tables import JOBS, POINTS, SWEEPS

if TYPE_CHECKING:
    from studies.sweeps.sweep import Point


class Searches(Commands):
    """The runs that a search adds."""

    def extend_search(self, lease: Lease, points: "Sequence[Point]") -> bool:
        """Add points to the sweep of a leased publication, which waits for them.

        Without effect (False) where the sweep was cancelled, or the lease has ended.
        """
        id, moment = lease.sweep_id, now()
        assert id is not None
        sweep = sa.select(SWEEPS.c.priority, SWEEPS.c.keep).where(SWEEPS.c.id == id, SWEEPS.c.cancelled.is_(None))
        last = sa.select(sa.func.max(POINTS.c.ordinal)).where(POINTS.c.sweep_id == id)
        wait = JOBS.update().where(is_held(lease)).values(state=State.WAITING, finished=sa.null())
        with self._commanding() as connection:
            row = connection.execute(sweep).first()
            if row is None or not connection.execute(wait).rowcount:
                return False
            first = connection.execute(last).scalar_one() + 1
            begin = fair_queueing.open_class(connection, row.priority)
            expanded = [*expanded_points(points, self._cost)]
            runs = run_rows(expanded, priority=row.priority, keep=row.keep, moment=moment, first=first)
            new = insert_new_runs(connection, runs, begin)
            insert_points(connection, id, expanded, first)
            if new < len(runs):
                ids = [run["id"] for run in runs]
                new += fair_queueing.queue_again(connection, id, moment, verdicts=False, among=ids)
                fair_queueing.schedule(connection, id, row.priority)
            counts = {"planned": SWEEPS.c.planned + len(points), "new": SWEEPS.c.new + new}
            connection.execute(SWEEPS.update().where(SWEEPS.c.id == id).values(counts))
            # The tally of a sweep whose points had all ended may be remembered.
            invalidate_tallies(connection, len(points))
            release_publications(connection, moment, JOBS.c.sweep_id == id)
            log_event(connection, moment, "extended", sweep_id=id, points=len(points), new=new)
        return True
