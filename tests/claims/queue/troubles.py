"""Failures around a service or within a run: the named state, and neighbours that notice nothing."""

from tests.acceptance.checks import troubles
from tests.claims import claim

troubles_of_runs = claim(
    "troubles-of-runs",
    says="a run that allocates without end, never ends, or crashes the interpreter has the named end, and no neighbour",
)(troubles.failing_runs)
trouble_locked = claim(
    "trouble-locked", says="a database that another program locks: refused with a reason, nothing lost"
)(troubles.database_locked)
trouble_away = claim(
    "trouble-away", says="a PostgreSQL server that crashes and comes back: refused with a reason, nothing lost"
)(troubles.database_away)
trouble_disk = claim(
    "trouble-disk", says="a disk that is full: nothing is begun, nothing is lost, and it goes on when there is room"
)(troubles.disk_full)
trouble_clock = claim(
    "trouble-clock", says="a clock that is set back by a day, and forward again: nothing is lost, nothing stops"
)(troubles.clock_set)
