"""The store for commands that work on it directly, beside a service or while none runs.

Functions import the libraries of the store themselves (0.3 s), which help and most commands do without.
"""

import os
import pwd
import socket
from collections.abc import Iterator
from contextlib import closing, contextmanager, suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from solver.errors import WhippleError

if TYPE_CHECKING:
    from service.settings import Settings
    from service.store import Store

DatabaseUrl = Annotated[
    str | None, typer.Option(help="Database; set WHIPPLE_DATABASE_URL instead if it contains a password.")
]


class NoStore(WhippleError):
    """There is no database to work on."""


@contextmanager
def open_store(settings: "Settings", *, create: bool = False) -> "Iterator[Store]":
    """The store of the settings; raises NoStore, StoreUnavailable.

    Existing tables are never upgraded here, because a running service may be older. A missing database is
    created if ``create`` is set.
    """
    from service.store import Store

    # A database on SQLite is a file in the data directory.
    if create and not settings.has_replicas:
        settings.data.mkdir(parents=True, exist_ok=True)
    if not create and not has_database(settings):
        cure = "give --data DIR, or set WHIPPLE_DATA or WHIPPLE_DATABASE_URL"
        raise NoStore(f"there is no database in {settings.data.absolute()}; {cure}")
    is_new = create and Store.revision(settings.url) is None
    with closing(Store.open(settings.url, migrate=is_new)) as store:
        yield store


def record_command(store: "Store", action: str, subject: str = "") -> None:
    """Record in the audit trail that the user of this process gave an order."""
    from service.records.jobs import AuditEntry

    uid, name = os.getuid(), ""
    with suppress(KeyError):  # a container's user without a name
        name = pwd.getpwuid(uid).pw_name
    store.audit.record(AuditEntry(datetime.now(UTC), None, name, f"uid {uid}", action, subject, "done"))


@contextmanager
def without_services(settings: "Settings", store: "Store") -> Iterator[None]:
    """Keep services away from the store for the duration of a block; raises DataInUse if one runs."""
    from service.files.data_directory import DataInUse, holding
    from service.queue import data_identity as identity

    with holding(settings):
        leadership = store.terms.lead(f"{socket.gethostname()}:{os.getpid()}")
        if leadership is None:
            leader = store.queue.status().leader or "a service"
            raise DataInUse(f"{leader} uses this database; stop every service on it first")
        with closing(leadership):
            identity.check(settings, store)
            yield


def has_database(settings: "Settings") -> bool:
    """Whether there is a database: opening a missing file with SQLite would create one."""
    return settings.has_replicas or Path(settings.url.partition(":///")[2]).is_file()
