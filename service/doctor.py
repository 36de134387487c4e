"""``whipple doctor``: is everything as it should be, and what to do where it is not.

Each check is a function of the settings that looks and changes nothing (but for a file of its own,
removed at once); a service may be running meanwhile. How to add one: a function here that yields
``Check`` records, and a place in ``CHECKS``. One that fails in a way that nobody foresaw is a finding,
not the end of the examination.
"""

import fcntl
import os
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from enum import StrEnum
from itertools import islice
from pathlib import Path

from service import identity
from service.artifacts import Artifacts
from service.jobs import StoreUnavailable
from service.leftovers import Leftovers, Why, files_from
from service.settings import Settings
from service.space import free_bytes, in_words
from service.store import Store
from service.version import version

SAMPLE = 200  # files whose digest is computed, unless all are asked for
NAMED = 3  # of many files with the same trouble
FILES_PER_WORKER = 32  # descriptors that a worker costs this process: connections, pipes
FILES_AT_LEAST = 256
PROBE_SECONDS = 60.0
CLOCK_SECONDS = 120.0  # that clocks may differ
BUILT = datetime(2026, 1, 1, tzinfo=UTC)  # no clock that is right is before
NETWORK = {"nfs", "nfs4", "cifs", "smb3", "smbfs", "9p", "fuse.sshfs", "lustre", "beegfs", "ceph"}
MOUNTS = Path("/proc/self/mounts")
KERNELS = "import solver.jit, numba; print(numba.config.CACHE_DIR)"


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


def examine(settings: Settings, *, every_file: bool = False) -> Iterator[Check]:
    """Every check in turn; ``every_file``: the digests of all files, not of a sample."""
    for name, check in CHECKS.items():
        try:
            yield from check(settings, every_file)
        except StoreUnavailable as error:
            yield Check(name, Verdict.WRONG, str(error), "see what is said of the database")
        except Exception as error:  # whatever it is, the others are looked at too
            detail = f"could not be looked at: {type(error).__name__}: {error}"
            yield Check(name, Verdict.WRONG, detail, "correct what it says, and ask again")


def directory_can_be_written(settings: Settings, _every: bool) -> Iterator[Check]:
    """The data directory: there, writable, and files get their names at once."""
    name = "data directory"
    try:
        with tempfile.NamedTemporaryFile(dir=settings.data, prefix=".doctor.") as file:
            file.write(b"x")
            file.flush()
            os.fsync(file.fileno())
    except OSError as error:
        cure = f"make {settings.data.absolute()} a folder that this user may write to"
        yield Check(name, Verdict.WRONG, f"cannot be written to: {error.strerror}", cure)
        return
    yield Check(name, Verdict.FINE, f"{settings.data.absolute()} can be written to")


def locks_work(settings: Settings, _every: bool) -> Iterator[Check]:
    """Locks of that filesystem keep a second one out; SQLite needs them, and we do."""
    name, kind = "filesystem", filesystem_of(settings.data)
    cure = "put the data directory on a disk of this machine, or use PostgreSQL"
    if not _locks_keep_out(settings.data):
        yield Check(name, Verdict.WRONG, f"locks do nothing on {kind}", cure)
    elif kind in NETWORK and not settings.has_replicas:
        yield Check(name, Verdict.WRONG, f"{kind}: SQLite loses data on a network's disk", cure)
    else:
        yield Check(name, Verdict.FINE, f"{kind}, locks work")


def database_is_current(settings: Settings, _every: bool) -> Iterator[Check]:
    """The database: there, and with the tables of this version."""
    name = "database"
    if not has_database(settings):
        cure = "none needed: the first start of the service makes it"
        yield Check(name, Verdict.WARNING, "there is none yet", cure)
        return
    schema = Store.schema(settings.url)
    if schema.found == schema.newest:
        yield Check(name, Verdict.FINE, f"tables of version {schema.newest}")
    elif schema.found is not None and schema.found > schema.newest:
        detail = f"tables of version {schema.found}; this is whipple {version()}, which knows {schema.newest}"
        yield Check(name, Verdict.WRONG, detail, "use the newer whipple that made them")
    else:
        detail = f"tables of version {schema.found}, the newest is {schema.newest}"
        cure = "make a backup, then start the service: it brings them up to date"
        yield Check(name, Verdict.WARNING, detail, cure)


def directory_belongs_to_database(settings: Settings, _every: bool) -> Iterator[Check]:
    """The id of the data directory, and that of the database."""
    name = "identity"
    if not _is_current(settings):
        return
    with closing(Store.open(settings.url, migrate=False)) as store:
        try:
            identity.check(settings, store)
        except identity.WrongDirectory as error:
            yield Check(name, Verdict.WRONG, error.what, error.cure)
            return
    yield Check(name, Verdict.FINE, "directory and database belong together")


def files_are_intact(settings: Settings, every_file: bool) -> Iterator[Check]:
    """Registered files: there, with their size and digest."""
    if not _is_current(settings):
        return
    artifacts = Artifacts(settings.data)
    with closing(Store.open(settings.url, migrate=False)) as store:
        files = [file for _, file in files_from(store, "")]
    chosen = files if every_file else files[:: max(1, len(files) // SAMPLE)]
    damaged = [file.path for file in chosen if not artifacts.is_intact(file)]
    looked = f"{len(chosen)} of {len(files)} files"
    if not damaged:
        yield Check("files", Verdict.FINE, f"{looked} have their size and digest")
        return
    cure = "bring them back from a backup; or retry these sweeps: what is lost is computed again"
    detail = f"{len(damaged)} of {looked} are lost or damaged: {_some(damaged)}"
    yield Check("files", Verdict.WRONG, detail, cure)


def nothing_is_left_over(settings: Settings, _every: bool) -> Iterator[Check]:
    """Files that no row points to: old ones should have been removed, strangers never are."""
    if not _is_current(settings):
        return
    with closing(Store.open(settings.url, migrate=False)) as store:
        leftovers = Leftovers(store, Artifacts(settings.data))
        found = [one for shard in leftovers.shards() for one in leftovers.of_shard(shard)]
        found += leftovers.of_sweeps(leftovers.sweep_ids())
        found += leftovers.strange_sweeps()
    strangers = [str(one.path) for one in found if one.why is Why.STRANGER]
    rest = [one for one in found if one.why is not Why.STRANGER]
    old = [one for one in rest if one.age() > 2 * settings.retire_seconds]
    if strangers:
        detail = f"{len(strangers)} are {Why.STRANGER}: {_some(strangers)}"
        cure = "is this the right database? After a backup was restored they can be removed by hand"
        yield Check("orphans", Verdict.WARNING, detail, cure)
    if old:
        detail = f"{len(old)} should be gone: {_some([str(one.path) for one in old])}"
        cure = "let the service run for an hour: it removes them"
        yield Check("orphans", Verdict.WARNING, detail, cure)
    if not strangers and not old:
        detail = f"{len(rest)} are waiting to be removed" if rest else "none"
        yield Check("orphans", Verdict.FINE, detail)


def disk_has_room(settings: Settings, _every: bool) -> Iterator[Check]:
    """Free space, against the reserve."""
    free, reserve = free_bytes(settings.data), settings.disk_reserve
    detail = f"{in_words(free)} are free, the reserve is {in_words(reserve)}"
    cure = "delete sweeps, make room, or set WHIPPLE_DISK_RESERVE"
    if free < reserve:
        yield Check("disk", Verdict.WRONG, f"{detail}: nothing is begun", cure)
    elif free < 2 * reserve:
        yield Check("disk", Verdict.WARNING, detail, cure)
    else:
        yield Check("disk", Verdict.FINE, detail)


def engine_can_be_reached(settings: Settings, _every: bool) -> Iterator[Check]:
    """The scheduler and its workers, where they are not our own."""
    if settings.engine is None:
        yield Check("engine", Verdict.FINE, f"{settings.workers} workers of our own")
        return
    yield from _certificates_can_be_read(settings)
    from service.execution import probe

    try:
        cluster = probe(settings)
    except OSError as error:
        cure = (
            "start the scheduler, open its port, and give both sides the same certificate authority"
        )
        yield Check("engine", Verdict.WRONG, f"{settings.engine} does not answer: {error}", cure)
        return
    refused = [f"{at} ({why})" for at, why in cluster.workers.items() if why]
    detail = f"{settings.engine} with {len(cluster.workers)} workers"
    if not cluster.workers:
        yield Check("engine", Verdict.WARNING, detail, "start workers")
    elif refused:
        detail += f", {len(refused)} of which get no work: {_some(refused)}"
        cure = "install the same versions everywhere, and start workers with --preload service.execution.dask_worker"
        some_work = len(refused) < len(cluster.workers)
        yield Check("engine", Verdict.WARNING if some_work else Verdict.WRONG, detail, cure)
    else:
        yield Check("engine", Verdict.FINE, detail)


def kernels_are_compiled(_settings: Settings, _every: bool) -> Iterator[Check]:
    """The solver's machine code, kept on disk; asked in a process of its own, which may load it."""
    asked = subprocess.run(
        [sys.executable, "-c", KERNELS],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=PROBE_SECONDS,
        check=False,
    )
    if asked.returncode:
        said = (asked.stderr.strip().splitlines() or ["it died"])[-1]
        yield Check(
            "kernels", Verdict.WRONG, f"the solver does not load: {said}", "install it again"
        )
        return
    folder = Path(asked.stdout.strip())
    compiled = sum(1 for _ in folder.rglob("*.nbc"))
    if compiled:
        yield Check("kernels", Verdict.FINE, f"{compiled} are compiled, in {folder}")
    else:
        cure = "run `whipple warm`; else the first run of each worker takes a minute more"
        yield Check("kernels", Verdict.WARNING, f"none is compiled in {folder}", cure)


def clock_is_sane(settings: Settings, _every: bool) -> Iterator[Check]:
    """Clocks: of this machine, of the disk and of what happened last. Only people read them."""
    cure = "set the clock (NTP); nothing is lost meanwhile, but times look odd"
    now = datetime.now(UTC)
    if now < BUILT:
        yield Check("clock", Verdict.WRONG, f"it says {now:%Y-%m-%d}", cure)
        return
    apart = abs(_time_of_disk(settings.data) - time.time())
    if apart > CLOCK_SECONDS:
        detail = f"the disk's clock is {apart:.0f} s away from this machine's"
        yield Check("clock", Verdict.WARNING, detail, cure)
        return
    last = _last_event(settings)
    if last is not None and last > now + timedelta(seconds=CLOCK_SECONDS):
        detail = (
            f"the last event is of {last:%Y-%m-%d %H:%M}, later than now: the clock was set back"
        )
        yield Check("clock", Verdict.WARNING, detail, cure)
        return
    yield Check("clock", Verdict.FINE, f"{now:%Y-%m-%d %H:%M} UTC")


def enough_files_can_be_open(settings: Settings, _every: bool) -> Iterator[Check]:
    """The limit on open files of this process."""
    allowed, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    wanted = FILES_AT_LEAST + FILES_PER_WORKER * settings.workers
    detail = f"{allowed} may be open at once"
    if allowed >= wanted or allowed == resource.RLIM_INFINITY:
        yield Check("open files", Verdict.FINE, detail)
        return
    cure = f"ulimit -n {wanted} before the start" + (" (as root)" if most < wanted else "")
    yield Check("open files", Verdict.WARNING, f"{detail}, {wanted} may be needed", cure)


CHECKS: dict[str, Callable[[Settings, bool], Iterator[Check]]] = {
    "data directory": directory_can_be_written,
    "filesystem": locks_work,
    "disk": disk_has_room,
    "database": database_is_current,
    "identity": directory_belongs_to_database,
    "files": files_are_intact,
    "orphans": nothing_is_left_over,
    "engine": engine_can_be_reached,
    "kernels": kernels_are_compiled,
    "clock": clock_is_sane,
    "open files": enough_files_can_be_open,
}


def filesystem_of(folder: Path) -> str:
    """The kind of filesystem that a folder is on; "unknown" where the system does not say."""
    place = folder.resolve()
    best, kind = Path("/"), "unknown"
    try:
        mounts = MOUNTS.read_text().splitlines()
    except OSError:
        return kind
    for line in mounts:
        _device, at, type, *_rest = line.split()
        point = Path(at.replace("\\040", " "))
        if place.is_relative_to(point) and len(point.parts) >= len(best.parts):
            best, kind = point, type
    return kind


def _locks_keep_out(folder: Path) -> bool:
    """Whether a file that is locked cannot be locked again."""
    with tempfile.NamedTemporaryFile(dir=folder, prefix=".doctor.") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        with open(file.name, "rb") as other:
            try:
                fcntl.flock(other, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                return True
    return False


def has_database(settings: Settings) -> bool:
    """Whether there is one to ask: SQLite would make an empty one."""
    return settings.has_replicas or Path(settings.url.partition(":///")[2]).is_file()


def _is_current(settings: Settings) -> bool:
    """Whether the tables can be read by this version; what is said of the database tells if not."""
    if not has_database(settings):
        return False
    schema = Store.schema(settings.url)
    return schema.found == schema.newest


def _certificates_can_be_read(settings: Settings) -> Iterator[Check]:
    for file in (settings.tls_ca, settings.tls_cert, settings.tls_key):
        if file is not None and not os.access(file, os.R_OK):
            cure = f"let this user read {file}"
            yield Check("engine", Verdict.WRONG, f"{file} cannot be read", cure)


def _time_of_disk(folder: Path) -> float:
    with tempfile.NamedTemporaryFile(dir=folder, prefix=".doctor.") as file:
        return os.stat(file.name).st_mtime


def _last_event(settings: Settings) -> datetime | None:
    if not _is_current(settings):
        return None
    with closing(Store.open(settings.url, migrate=False)) as store:
        events = store.all_events(after=store.last_event() - 1, limit=1)
    return events[0].time if events else None


def _some(names: list[str]) -> str:
    more = len(names) - NAMED
    return ", ".join(islice(names, NAMED)) + (f" and {more} more" if more > 0 else "")
