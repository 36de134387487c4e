"""The only part with a database connection: every query of the service, each with a name.

One text serves SQLite and PostgreSQL. The records that go in and out are those of ``service.jobs``;
a state moves only as its ``MOVES`` allow, because each update names the states it may start from.

* ``tables``: what is stored
* ``connection``: one transaction at a time; tables brought up to date at start
* ``queries``: expressions and statements that several methods share
* ``rows``: rows to records, and back
* ``queue``: what the dispatcher does: claim, finish, fail, requeue
* ``store``: what people ask and order: accept, list, cancel, retry, delete
"""

from service.store.rows import digest_of
from service.store.store import Store

__all__ = ["Store", "digest_of"]
