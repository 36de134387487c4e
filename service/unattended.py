"""Work on a store from the command line: beside a service, or where none runs."""

import os
import socket
from collections.abc import Iterator
from contextlib import closing, contextmanager

from service import identity
from service.directory import DataInUse, holding
from service.doctor import has_database
from service.jobs import Cause, Kind
from service.reign import Parts
from service.settings import Settings
from service.store import Store
from service.supervisor import Supervisor
from service.warm import Slot
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


def publish_what_waits(settings: Settings, store: Store) -> bool:
    """Publish, in a process of our own, every sweep that waits for it; False: a service sees to it.

    Runs are left alone. Whatever ends this is made good by who comes next.
    """
    try:
        with holding(settings):
            leadership = store.lead(f"{socket.gethostname()}:{os.getpid()}")
            if leadership is None:
                return False
            with closing(leadership):
                identity.check(settings, store)
                _publish_all(settings, store)
            return True
    except DataInUse:
        return False


def _publish_all(settings: Settings, store: Store) -> None:
    parts = Parts.of(settings, store)
    epoch = store.begin_epoch("whipple remeasure")
    for lost in store.claimed():  # by somebody who is gone: else we would not lead
        if lost.kind is Kind.PUBLISH:
            store.requeue(lost, Cause.LOST, reason="the service was gone")
    with closing(Slot()) as slot:
        while claims := store.claim(1, epoch, publications_only=True):
            for claim in claims:
                ending = Supervisor(parts.tickets.write(claim), lambda _: None).run(slot)
                parts.registrar.settle(claim, parts.inspector.look(claim, ending))
                if ending.cause is Cause.LOST:
                    raise WhippleError(ending.reason)
                shortage = parts.space.shortage()
                if shortage is not None:
                    raise WhippleError(f"{shortage}; make room, and ask again")
