"""``whipple doctor``: checks of data directory, database and workers, each with a cure for what is wrong.

Each check is a function of the settings that yields ``Check`` records. It changes nothing, except for a temporary
file of its own, and may run beside a service.
"""

import os
import tempfile
from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime
from enum import StrEnum

from service import execution
from service.files.artifacts import Artifacts
from service.files.stores import FilesAway
from service.maintenance.offline import has_database
from service.queue import data_identity as identity
from service.records.jobs import StoreDamaged, StoreUnavailable
from service.settings import Settings
from service.store import Store
from studies.quantities.findings import InvalidInput

# Of a backup that `whipple backup OUT` made.
RESTORE = (
    "restore the last backup: stop the service, move {folder} aside, copy the folder of the backup to its place, run "
    "the check again, then start the service; results since the backup are computed again when a sweep asks for them, "
    "and sweeps accepted since have to be submitted again"
)


class CheckStatus(StrEnum):
    OK = "ok"
    WARNING = "warning"  # it works, with a limitation
    ERROR = "error"


@dataclass(frozen=True)
class Check:
    name: str
    status: CheckStatus
    detail: str
    cure: str = ""  # empty if none is needed


def examine(settings: Settings) -> Iterator[Check]:
    yield from check_directory(settings)
    yield from check_bucket(settings)
    yield from check_store(settings)
    yield from check_workers(settings)


def check_directory(settings: Settings) -> Iterator[Check]:
    """Whether the data directory exists and is writable."""
    folder = settings.data.absolute()
    try:
        with tempfile.NamedTemporaryFile(dir=settings.data, prefix=".doctor.") as file:
            os.fsync(file.fileno())
    except OSError as error:
        cure = f"make {folder} a folder that this user may write to"
        detail = f"not writable: {error.strerror}"
        yield Check("data directory", CheckStatus.ERROR, detail, cure)
    else:
        yield Check("data directory", CheckStatus.OK, f"{folder} is writable")


def check_bucket(settings: Settings) -> Iterator[Check]:
    """Whether the bucket can be written to, and whether it keeps what was removed; none without one."""
    try:
        bucket = Artifacts.of(settings).bucket
        if bucket is None:
            return
        is_versioned = bucket.probe()
    except (FilesAway, InvalidInput) as error:
        cure = "give WHIPPLE_ARTIFACTS a bucket that exists, and the environment its credentials and AWS_ENDPOINT_URL"
        yield Check("bucket", CheckStatus.ERROR, str(error), cure)
        return
    detail, cure = f"{bucket.url} is writable", ""
    if is_versioned:
        detail, cure = (
            f"{detail}, and keeps old versions",
            "let a lifecycle rule of the bucket expire noncurrent versions",
        )
    yield Check("bucket", CheckStatus.WARNING if is_versioned else CheckStatus.OK, detail, cure)


def check_store(settings: Settings) -> Iterator[Check]:
    """Whether the database exists, has the tables of this version, and belongs to the data directory."""
    if not has_database(settings):
        cure = "start the service: the first start creates the database"
        yield Check("database", CheckStatus.WARNING, "there is no database yet", cure)
        return
    try:
        with closing(Store.open(settings.url, migrate=False)) as store:
            store.database.check_pages()
            identity.check(settings, store)
            whole = store.retention.scrub().whole
    except StoreDamaged as error:
        yield Check("database", CheckStatus.ERROR, str(error), RESTORE.format(folder=settings.data.absolute()))
    except StoreUnavailable as error:
        yield Check("database", CheckStatus.ERROR, str(error), "correct the problem, then run the check again")
    except identity.WrongDirectory as error:
        yield Check("database", CheckStatus.ERROR, error.what, error.cure)
    else:
        detail = "the tables are current, and the database belongs to the data directory"
        yield Check("database", CheckStatus.OK, detail)
        yield _check_files(*whole) if whole else Check("stored files", CheckStatus.OK, "not yet compared with digests")


def _check_files(ended: float, files: float, damaged: float) -> Check:
    """The outcome of the last comparison of all stored files with their digests."""
    cure = "the log of the service names them; a few a day are made again: `whipple doctor --forget-lost` allows more"
    detail = f"{files} compared with their digests until {datetime.fromtimestamp(ended, UTC):%Y-%m-%d %H:%M} UTC, "
    status = CheckStatus.WARNING if damaged else CheckStatus.OK
    return Check("stored files", status, f"{detail}{damaged} damaged", cure if damaged else "")


def check_workers(settings: Settings) -> Iterator[Check]:
    """The workers of this machine, or those of the engine."""
    if settings.engine is None:
        yield Check("workers", CheckStatus.OK, f"{settings.workers} on this machine")
        return

    try:
        workers = execution.probe(settings)
    except OSError as error:
        cure = "start the scheduler, open its port, and give both sides the same certificate authority"
        detail = f"{settings.engine} does not respond: {error}"
        yield Check("workers", CheckStatus.ERROR, detail, cure)
        return
    refused = [f"{address} ({reason})" for address, reason in workers.items() if reason]
    detail = f"{settings.engine} with {len(workers)} workers"
    status, cure = CheckStatus.OK, ""
    if not workers:
        status, cure = CheckStatus.WARNING, "start workers"
    elif refused:
        detail += f", {len(refused)} of the workers receive no work: {', '.join(refused)}"
        cure = "start them as docs/cluster.md has it, with the same versions everywhere"
        status = CheckStatus.WARNING if len(refused) < len(workers) else CheckStatus.ERROR
    yield Check("workers", status, detail, cure)
