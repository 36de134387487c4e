"""The only part with a database connection: every query of the service, each with a name.

One text serves SQLite and PostgreSQL. The records that go in and out are those of ``service.records.jobs``;
a state moves only as its ``MOVES`` allow, because each update names the states it may start from.

* ``tables``: what is stored
* ``connection``: one writer at a time, and why; tables brought up to date at start
* ``identity``: which data directory belongs to the database
* ``leadership``: which service works through the queue
* ``queries``: expressions and statements that several methods share
* ``turns``: fairness between sweeps, priorities
* ``rows``: rows to records, and back
* ``queue``: what the dispatcher does: claim, adopt, finish, fail, requeue
* ``care``: which files still count
* ``orders``: what people order: accept, cancel, retry, delete, pause
* ``questions``, ``overview``: what people ask of sweeps and runs, and of the queue as a whole
* ``keys``: API keys
* ``store``: all of it
"""

from service.store.leadership import Leadership
from service.store.rows import digest_of
from service.store.store import Store

__all__ = ["Leadership", "Store", "digest_of"]
