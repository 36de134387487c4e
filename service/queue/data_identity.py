"""The identity of the data directory: an id in a file there, and the same id in the database.

Rows are of no use without their files. A service in another directory, such as an empty folder where a disk is not
mounted, would take every registered result for lost, so it neither starts nor leads there.
"""

import uuid
from pathlib import Path

from service.files.artifacts import RUNS, Artifacts
from service.files.stores import IDENTITY
from service.settings import Settings
from service.store import Store
from solver.errors import WhippleError
from studies.quantities.files import write_text
from studies.quantities.findings import Finding, InvalidInput

ADOPT = "join the two with `whipple doctor --adopt`, which takes --data and --database-url"


class WrongDirectory(WhippleError):
    """The data directory is not the one that belongs to the database."""

    def __init__(self, data: Path, what: str, cure: str):
        super().__init__(f"{data.absolute()}: {what}; {cure}")
        self.what = what  # without the path, which stays inside the machine
        self.cure = cure


def settle(settings: Settings, store: Store) -> None:
    """Give directory, database and bucket an id where none has one; raises WrongDirectory where they differ.

    A directory without an id is as good as an emptied one where the bucket has the files. Raises FilesAway.
    """
    bucket = Artifacts.of(settings).bucket
    in_bucket = None if bucket is None else bucket.identity()

    def choose(in_database: str | None) -> str | None:
        if in_database is not None and in_database == in_bucket and read(settings.data) is None:
            settings.data.mkdir(parents=True, exist_ok=True)
            write(settings.data, in_database)
        if in_database is not None or read(settings.data) is not None:
            return in_database
        if store.retention.files(limit=1) and not (settings.data / RUNS).is_dir():
            what = "the data directory has no results, its database has some"
            raise WrongDirectory(settings.data, what, f"mount it, or {ADOPT}")
        settings.data.mkdir(parents=True, exist_ok=True)
        return write(settings.data, uuid.uuid4().hex)

    id = store.choose_data_id(choose)
    check(settings, store)
    if bucket is not None and id is not None and in_bucket is None:
        bucket.identify(id)
    elif bucket is not None and in_bucket != id:
        what = f"the bucket {bucket.url} has {_named(in_bucket)}, and the database has {_named(id)}"
        raise WrongDirectory(settings.data, what, f"choose another prefix, or {ADOPT}")


def check(settings: Settings, store: Store) -> None:
    """Raise WrongDirectory unless the directory has the id of the database."""
    here, there = read(settings.data), store.data_id()
    if here == there:
        return
    if settings.data.is_dir():
        has, cure = f"has {_named(here)}", f"use the one that belongs to the database, or {ADOPT}"
    else:
        has, cure = "is missing", "mount the directory, or move it back"
    what = f"the data directory {has}, and its database has {_named(there)}"
    raise WrongDirectory(settings.data, what, cure)


def adopt(settings: Settings, store: Store) -> str:
    """Let an existing directory belong to the database; the id of both, which is the database's if it has one."""
    if not settings.data.is_dir():
        cure = "mount it, or correct the path"
        raise InvalidInput([Finding("--data", str(settings.data), "a folder that is there", cure)])

    def choose(in_database: str | None) -> str:
        return write(settings.data, in_database or read(settings.data) or uuid.uuid4().hex)

    id = str(store.choose_data_id(choose))
    bucket = Artifacts.of(settings).bucket
    if bucket is not None:
        bucket.identify(id)
    return id


def read(data: Path) -> str | None:
    """The id of a directory; None: the directory or its id is missing. Raises WrongDirectory."""
    try:
        return (data / IDENTITY).read_text(encoding="utf-8", errors="replace").strip()
    except FileNotFoundError:
        return None
    except OSError as error:
        what = f"the id of the data directory cannot be read: {error.strerror}"
        raise WrongDirectory(data, what, f"let this user read {IDENTITY}, or mount the data directory") from error


def write(data: Path, id: str) -> str:
    write_text(data / IDENTITY, f"{id}\n")
    return id


def _named(id: str | None) -> str:
    return "no id" if id is None else f"the id {id}"
