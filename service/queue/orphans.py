"""Files in the data directory that no longer count, and why; found without deleting anything.

What counts is the folder of a job's last attempt, and whatever a row points to. The folder of a
run or sweep that the store does not know stays: the directory belongs to another database, or is newer than a
backup that was restored.
"""

import re
import time
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import TypeVar

from service.files.artifacts import CHECKPOINT, ID, PART, RUNS, SWEEPS, Artifacts, name_of_attempt
from service.records.jobs import KEPT_BY, TERMINAL, LastAttempt, State, Stored
from service.store import Store

ATTEMPT = re.compile(r"a(\d+)-[0-9a-f]+")
SHARD = re.compile("[0-9a-f]{2}")
FILES_ON_A_PAGE = 1000

Item = TypeVar("Item")
PART_OF_ALL = 50  # folders that are looked at together

Registered = Mapping[str, Set[Path]]  # files that rows point to, by run


class Why(StrEnum):
    """Why something is left over."""

    LOST = "an attempt that does not count"
    PART = "half-written"
    DRAFT = "half-written, of a run that is under way"
    SPENT = "a checkpoint of a run that has a result"
    RESTING = "a checkpoint of a run that ended without a result"
    DROPPED = "no longer kept"
    DELETED = "of a sweep that was deleted"
    FORGOTTEN = "of a run that no sweep has had for long"


@dataclass(frozen=True)
class Leftover:
    """A file or folder that does not count."""

    path: Path
    why: Why

    def age(self) -> float:
        """Seconds since something was written there: for patience, no decision about a run."""
        try:
            newest = max(one.stat().st_mtime for one in (self.path, *self.path.glob("*")))
        except OSError:  # it goes while we look
            return 0.0
        return time.time() - newest


@dataclass(frozen=True)
class Counted:
    """What counts of a run."""

    attempt: LastAttempt  # the last
    registered: Set[Path]  # files that rows point to


class Leftovers:
    """Looks through the folders of runs and sweeps."""

    def __init__(self, store: Store, artifacts: Artifacts):
        self._store = store
        self._artifacts = artifacts

    def _of_runs(self, folders: Sequence[Path]) -> Iterator[Leftover]:
        """What is left over of neighbours in the order of ids: a few statements for all of them."""
        ids = [folder.name for folder in folders]
        known, registered = self._store.known_attempts(ids), self._registered(ids)
        forgotten = self._store.forgotten_runs([id for id in ids if id not in known])
        for folder in folders:
            id = folder.name
            if id in known:
                yield from _of_run(folder, Counted(known[id], registered[id]))
            elif id in forgotten:
                yield Leftover(folder, Why.FORGOTTEN)

    def _of_sweeps(self, ids: Sequence[str]) -> Iterator[Leftover]:
        """What is left over of these sweeps."""
        deleted = self._store.forgotten(ids)
        for id in ids:
            folder = self._artifacts.sweep_folder(id)
            if id in deleted:
                yield Leftover(folder, Why.DELETED)
            else:
                yield from self._of_sweep(id, _attempts(folder))

    def parts(self) -> Iterator[Iterator[Leftover]]:
        """What is left over of everything, in parts that take a moment each."""
        for folders in _in_parts(_folders(self._artifacts.root / SWEEPS, ID)):
            yield self._of_sweeps([folder.name for folder in folders])
        for shard in _folders(self._artifacts.root / RUNS, SHARD):
            for folders in _in_parts(_folders(shard, ID)):
                yield self._of_runs(folders)

    def _of_sweep(self, id: str, attempts: Sequence[Path]) -> Iterator[Leftover]:
        """Publications that were replaced; the youngest never is, and may be under way."""
        if len(attempts) < 2:
            return
        counted = {self._artifacts.path(file).parent for file in self._store.artifacts(id)}
        for attempt in attempts[:-1]:
            if counted and attempt not in counted:
                yield Leftover(attempt, Why.LOST)

    def _registered(self, ids: Sequence[str]) -> Registered:
        """What rows point to of these runs, which are neighbours in the order of ids."""
        found: dict[str, set[Path]] = {id: set() for id in ids}
        for id, file in self._store.files_between(ids[0], ids[-1]):
            if id in found:
                found[id].add(self._artifacts.root / file.path)
        return found


def files_from(store: Store, id: str) -> Iterator[tuple[str, Stored]]:
    """Every registered file of the jobs from ``id`` on, in their order, page by page."""
    after = (id, "")
    while page := store.files(after=after, limit=FILES_ON_A_PAGE):
        yield from page
        last, file = page[-1]
        after = (last, file.name)


def _of_run(folder: Path, counts: Counted) -> Iterator[Leftover]:
    """What is left over of one run."""
    attempt, registered = counts.attempt, counts.registered
    last = name_of_attempt(attempt.attempt, attempt.token) if attempt.token else ""
    has_ended = attempt.state in TERMINAL
    is_under_way = attempt.state in (State.RUNNING, State.CANCELLING)
    for one in _attempts(folder):
        if one.name == last:
            if has_ended:
                yield from _of_attempt(one, counts)
        elif not any(file.is_relative_to(one) for file in registered):
            yield Leftover(one, Why.LOST)
    for file in folder.glob(f".{CHECKPOINT}{PART}"):
        yield Leftover(file, Why.DRAFT if is_under_way else Why.PART)
    if has_ended:
        why = Why.SPENT if attempt.state is State.SUCCEEDED else Why.RESTING
        for file in folder.glob(f"{CHECKPOINT}*"):
            yield Leftover(file, why)


def _of_attempt(folder: Path, counts: Counted) -> Iterator[Leftover]:
    """What is left over in the folder that counts, once nobody writes there."""
    for file in folder.glob(PART):
        yield Leftover(file, Why.PART)
    for name in KEPT_BY:
        if folder / name not in counts.registered and (folder / name).exists():
            yield Leftover(folder / name, Why.DROPPED)


def _in_parts(items: Sequence[Item]) -> Iterator[Sequence[Item]]:
    """The same, so many at a time."""
    return (items[begin : begin + PART_OF_ALL] for begin in range(0, len(items), PART_OF_ALL))


def _attempts(folder: Path) -> list[Path]:
    """The folders of attempts, the youngest last."""
    found = ((ATTEMPT.fullmatch(entry.name), entry) for entry in folder.glob("a*"))
    return [entry for match, entry in sorted((int(m[1]), e) for m, e in found if m)]


def _folders(parent: Path, name: re.Pattern[str]) -> list[Path]:
    """The entries with names of one kind, in order."""
    if not parent.is_dir():
        return []
    return sorted(entry for entry in parent.iterdir() if name.fullmatch(entry.name))
