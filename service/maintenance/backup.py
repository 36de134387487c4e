"""A backup of database and files of a service on SQLite, while it runs.

The database is copied first, at one moment, then every file that its rows name: files are complete before a row
names them, and never change. Files that a sweep deleted in between are removed from the copied rows. Files of an
earlier backup are not copied again, and the database is replaced last: the folder holds a complete backup at any
moment, the earlier one or the new one.
"""

import os
import shutil
from collections.abc import Iterator
from contextlib import closing, suppress
from dataclasses import dataclass, replace
from pathlib import Path

from service.files.artifacts import Artifacts, digest
from service.files.data_directory import holding
from service.queue import data_identity as identity
from service.records.jobs import Stored
from service.settings import Settings
from service.store import Store
from studies.quantities.files import to_disk, write_atomically
from studies.quantities.findings import Finding, InvalidInput

DATABASE = "whipple.db"
PART = f".{DATABASE}.part"
FILES_ON_A_PAGE = 1000


def files_of(store: Store) -> Iterator[tuple[str, Stored]]:
    """Every registered file with its job, page by page."""
    after = ("", "")
    while page := store.retention.files(after=after, limit=FILES_ON_A_PAGE):
        yield from page
        last, file = page[-1]
        after = (last, file.name)


@dataclass(frozen=True)
class Backup:
    folder: Path
    copied: int = 0  # files
    size: int = 0  # bytes of these
    present: int = 0  # files of an earlier backup
    removed: int = 0  # files that the service deleted meanwhile
    lost: tuple[str, ...] = ()  # files that are missing or damaged in the service


def back_up(settings: Settings, out: Path, store: Store) -> Backup:
    """Copy database and files into a folder, which then is a data directory.

    Raises InvalidInput, DataInUse if a service uses the folder, StoreUnavailable, OSError.
    """
    _check(settings, out)
    with holding(Settings(data=out, database_url=None)):
        part = out / PART
        _remove(part)
        store.database.copy_to(part)
        with closing(Store.open(f"sqlite:///{part.absolute()}", migrate=False)) as copy:
            done = _copy_files(Artifacts.of(settings), store, Artifacts(out), copy)
            id = copy.data_id()
        if id is not None:
            identity.write(out, id)
        to_disk(part)
        _remove(out / DATABASE, logs_only=True)
        part.replace(out / DATABASE)
        to_disk(out)
    return done


def _copy_files(source: Artifacts, store: Store, target: Artifacts, copy: Store) -> Backup:
    done = Backup(target.root)
    for job_id, file in files_of(copy):
        if target.is_intact(file):
            done = replace(done, present=done.present + 1)
        elif _copy(source, file, target):
            done = replace(done, copied=done.copied + 1, size=done.size + file.size)
        elif (job_id, file) in store.retention.files_between(job_id, job_id):
            done = replace(done, lost=(*done.lost, file.path))
        else:
            copy.retention.forget_files(job_id, [file.name])
            done = replace(done, removed=done.removed + 1)
    return done


def _copy(source: Artifacts, file: Stored, target: Artifacts) -> bool:
    """Copy a file as a whole; False if it is missing or damaged."""
    path = target.root / file.path
    path.parent.mkdir(parents=True, exist_ok=True)

    def fill(part: Path) -> None:
        shutil.copyfile(source.local(file), part)
        if digest(part) != file.sha256:
            raise FileNotFoundError

    with suppress(FileNotFoundError):
        write_atomically(path, fill)
        return True
    return False


def _remove(database: Path, *, logs_only: bool = False) -> None:
    """Remove the log files that SQLite keeps beside a database, and the database itself."""
    for suffix in ("-wal", "-shm", *([] if logs_only else [""])):
        database.with_name(f"{database.name}{suffix}").unlink(missing_ok=True)


def _check(settings: Settings, out: Path) -> None:
    """Check database and folder; raises InvalidInput."""
    data, folder = settings.data.resolve(), out.resolve()
    if settings.has_replicas:
        cure = "pg_dump the database, then copy the data directory: docs/service.md, Backup"
        raise InvalidInput([Finding("database", "PostgreSQL", "SQLite", cure)])
    if folder.is_relative_to(data) or data.is_relative_to(folder):
        limit = "a folder apart from the data directory"
        raise InvalidInput([Finding("OUT", str(out), limit, "choose another one")])
    try:
        out.mkdir(parents=True, exist_ok=True)
        if not os.access(out, os.W_OK):
            raise PermissionError(None, "not writable")
    except OSError as error:
        cure = f"choose another folder: {error.strerror}"
        raise InvalidInput([Finding("OUT", str(out), "a writable folder", cure)]) from None
