"""The only room with a database connection: every command and query of the service, each with a name.

``Store`` is the facade; ``tables`` says what is stored, ``connection`` how writers follow one another. One
text serves SQLite and PostgreSQL. Records that go in and out are those of ``service.records.jobs``; each
update of a state names the states that it may start from. Called by queue, API and command line.
"""

from service.store.commands import digest_of
from service.store.leadership import Leadership
from service.store.store import Store

__all__ = ["Leadership", "Store", "digest_of"]
