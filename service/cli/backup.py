"""A copy of database and files of a service on SQLite, while it runs.

The database is copied first, as it is at one moment, then every file that its rows name: files are
complete before a row names them, and never change. What was removed meanwhile, because its sweep was
deleted or keeps it no longer, is taken out of the copy's rows. Files that are there from an earlier
backup are not copied again, and the database takes its name last: what is in the folder is a whole
backup at any moment, the earlier one or this.
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
from service.records.settings import Settings
from service.store import Store
from studies.values.errors import Finding, InvalidInput
from studies.values.files import to_disk, write_atomically

DATABASE = "whipple.db"
PART = f".{DATABASE}.part"
FILES_ON_A_PAGE = 1000


@dataclass(frozen=True)
class Backup:
    """What was copied."""

    folder: Path
    copied: int = 0  # files
    size: int = 0  # bytes of these
    known: int = 0  # files that were there from an earlier backup
    removed: int = 0  # files that went meanwhile, in order
    lost: tuple[str, ...] = ()  # files that the service has lost, or that are damaged


def back_up(settings: Settings, out: Path, store: Store) -> Backup:
    """Copy database and files into a folder, which then is a data directory.

    Raises InvalidInput, DataInUse where a service works in the folder, StoreUnavailable, OSError.
    """
    _check(settings, out)
    with holding(Settings(data=out, database_url=None)):
        part = out / PART
        _remove(part)
        store.copy_to(part)
        with closing(Store.open(f"sqlite:///{part.absolute()}", migrate=False)) as copy:
            done = _copy_files(Artifacts(settings.data), store, Artifacts(out), copy)
            id = copy.data_id()
        if id is not None:
            identity.write(out, id)
        to_disk(part)
        _remove(out / DATABASE, but_the_file=True)
        part.replace(out / DATABASE)
        to_disk(out)
    return done


def _copy_files(source: Artifacts, store: Store, target: Artifacts, copy: Store) -> Backup:
    done = Backup(target.root)
    for job_id, file in files_from(copy, ""):
        if target.is_intact(file):
            done = replace(done, known=done.known + 1)
        elif _is_copied(source, file, target):
            done = replace(done, copied=done.copied + 1, size=done.size + file.size)
        elif file in _files_of(store, job_id):
            done = replace(done, lost=(*done.lost, file.path))
        else:
            copy.forget_files(job_id, [file.name])
            done = replace(done, removed=done.removed + 1)
    return done


def _is_copied(source: Artifacts, file: Stored, target: Artifacts) -> bool:
    """Copy a file, whole or not at all; whether it is what its row says."""
    place = target.root / file.path
    place.parent.mkdir(parents=True, exist_ok=True)

    def fill(part: Path) -> None:
        shutil.copyfile(source.path(file), part)
        if digest(part) != file.sha256:
            raise _Damaged

    with suppress(FileNotFoundError, _Damaged):
        write_atomically(place, fill)
        return True
    return False


def _files_of(store: Store, job_id: str) -> Iterator[Stored]:
    """What the service's own rows name of a job now."""
    for id, file in files_from(store, job_id):
        if id != job_id:
            return
        yield file


class _Damaged(Exception):
    """A file is not what its row says."""


def _remove(file: Path, *, but_the_file: bool = False) -> None:
    """Remove a database with what SQLite keeps beside it."""
    for end in ("-wal", "-shm", *([] if but_the_file else [""])):
        file.with_name(f"{file.name}{end}").unlink(missing_ok=True)


def _check(settings: Settings, out: Path) -> None:
    """Raises InvalidInput for what cannot be backed up like this."""
    here, there = settings.data.resolve(), out.resolve()
    if settings.has_replicas:
        cure = "pg_dump the database, then copy the data directory: docs/service.md, Backup"
        raise InvalidInput([Finding("database", "PostgreSQL", "SQLite", cure)])
    if there == here or there.is_relative_to(here) or here.is_relative_to(there):
        limit = "a folder apart from the data directory"
        raise InvalidInput([Finding("OUT", str(out), limit, "choose another one")])
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        cure = f"choose another one: {error.strerror}"
        raise InvalidInput([Finding("OUT", str(out), "a folder that can be made", cure)]) from None
    if not os.access(out, os.W_OK):
        raise InvalidInput([Finding("OUT", str(out), "a folder to write to", "choose another one")])


def files_from(store: Store, id: str) -> Iterator[tuple[str, Stored]]:
    """Every registered file of the jobs from ``id`` on, in their order, page by page."""
    after = (id, "")
    while page := store.files(after=after, limit=FILES_ON_A_PAGE):
        yield from page
        last, file = page[-1]
        after = (last, file.name)
