"""Work on a store from the command line: beside a service, or where none runs."""

import os
import socket
from collections.abc import Iterator
from contextlib import closing, contextmanager

from service.cli.doctor import has_database
from service.files.data_directory import DataInUse, holding
from service.queue import data_identity as identity
from service.records.settings import Settings
from service.store import Store
from solver.errors import WhippleError


class NoStore(WhippleError):
    """There is no database to work on."""


@contextmanager
def open_store(settings: Settings, *, make: bool = False) -> Iterator[Store]:
    """The store of these settings, as a service may be using it; raises NoStore, StoreUnavailable.

    Its tables are never brought up to date here: a service that runs may not know the new ones.
    ``make``: a database that is not there is made.
    """
    if make and not settings.has_replicas:  # the database is a file there
        settings.data.mkdir(parents=True, exist_ok=True)
    if not make and not has_database(settings):
        cure = "give --data DIR, or set WHIPPLE_DATA or WHIPPLE_DATABASE_URL"
        raise NoStore(f"there is no database in {settings.data.absolute()}; {cure}")
    is_new = make and Store.revision(settings.url) is None
    with closing(Store.open(settings.url, migrate=is_new)) as store:
        yield store


@contextmanager
def without_services(settings: Settings, store: Store) -> Iterator[None]:
    """Keep services from working on the store until the end of the block; raises DataInUse while one does."""
    with holding(settings):
        leadership = store.lead(f"{socket.gethostname()}:{os.getpid()}")
        if leadership is None:
            leader = store.queue().leader or "a service"
            raise DataInUse(f"{leader} works on this database; stop every service on it first")
        with closing(leadership):
            identity.check(settings, store)
            yield
