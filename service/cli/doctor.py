"""``whipple doctor``: data directory, store and workers, with a cure where something is wrong.

Each check is a function of the settings that yields ``Check`` records and changes nothing (but for a file of its own,
removed at once); a service may be running meanwhile.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from service.queue import data_identity as identity
from service.records.jobs import StoreUnavailable
from service.records.settings import Settings
from service.store import Store


class Verdict(StrEnum):
    """What a check found."""

    FINE = "fine"
    WARNING = "warning"  # it works, but not for long or not well
    WRONG = "wrong"


@dataclass(frozen=True)
class Check:
    """One thing that was looked at."""

    name: str
    verdict: Verdict
    detail: str  # what was found
    cure: str = ""  # what to do; nothing where it is fine


def examine(settings: Settings) -> Iterator[Check]:
    """Every check in turn."""
    yield from check_directory(settings)
    yield from check_store(settings)
    yield from check_workers(settings)


def check_directory(settings: Settings) -> Iterator[Check]:
    """The data directory: there, and writable."""
    place = settings.data.absolute()
    try:
        with tempfile.NamedTemporaryFile(dir=settings.data, prefix=".doctor.") as file:
            os.fsync(file.fileno())
    except OSError as error:
        cure = f"make {place} a folder that this user may write to"
        yield Check(
            "data directory", Verdict.WRONG, f"cannot be written to: {error.strerror}", cure
        )
    else:
        yield Check("data directory", Verdict.FINE, f"{place} can be written to")


def check_store(settings: Settings) -> Iterator[Check]:
    """The database: there, with the tables of this version, and of this data directory."""
    if not has_database(settings):
        cure = "none needed: the first start of the service makes it"
        yield Check("store", Verdict.WARNING, "there is no database yet", cure)
        return
    try:
        with closing(Store.open(settings.url, migrate=False)) as store:
            identity.check(settings, store)
    except StoreUnavailable as error:
        yield Check("store", Verdict.WRONG, str(error), "do what it says, and ask again")
    except identity.WrongDirectory as error:
        yield Check("store", Verdict.WRONG, error.what, error.cure)
    else:
        yield Check(
            "store", Verdict.FINE, "its tables are current, and the data directory is its own"
        )


def check_workers(settings: Settings) -> Iterator[Check]:
    """The scheduler and its workers, where they are not our own."""
    if settings.engine is None:
        yield Check("workers", Verdict.FINE, f"{settings.workers} of our own")
        return
    from service.execution import probe

    try:
        cluster = probe(settings)
    except OSError as error:
        cure = (
            "start the scheduler, open its port, and give both sides the same certificate authority"
        )
        yield Check("workers", Verdict.WRONG, f"{settings.engine} does not answer: {error}", cure)
        return
    refused = [f"{at} ({why})" for at, why in cluster.workers.items() if why]
    detail = f"{settings.engine} with {len(cluster.workers)} workers"
    if not cluster.workers:
        yield Check("workers", Verdict.WARNING, detail, "start workers")
    elif refused:
        detail += f", {len(refused)} of which get no work: {', '.join(refused)}"
        cure = "install the same versions everywhere, and start workers with --preload service.execution.dask_worker"
        some_work = len(refused) < len(cluster.workers)
        yield Check("workers", Verdict.WARNING if some_work else Verdict.WRONG, detail, cure)
    else:
        yield Check("workers", Verdict.FINE, detail)


def has_database(settings: Settings) -> bool:
    """Whether there is one to ask: SQLite would make an empty one."""
    return settings.has_replicas or Path(settings.url.partition(":///")[2]).is_file()
