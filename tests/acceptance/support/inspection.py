"""Inspection after a crash test: rows, files, and every variable of every cube."""

import json
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np
import xarray as xr

from service.api.app import CACHE
from service.files.artifacts import CHECKPOINT, ID, PART, RUNS, Artifacts
from service.records.jobs import RunRow, State, Stored, SweepStatus
from service.store import Store
from studies.values.files import RESULT
from tests.service.store.test_races import check as nobody_waits_in_vain

TEXT_KINDS = "OSU"  # of arrays; text in a part is as wide as the longest of the whole
PAGE = 1000


def runs(store: Store, sweeps: list[str]) -> dict[str, RunRow]:
    """All runs of sweeps, each once."""
    points = (point for id in sweeps for point in store.sweep_runs(id, limit=PAGE).items)
    return {point.run.id: point.run for point in points}


def registrations(store: Store) -> Counter[str]:
    """How often each job was registered as done: events are never removed."""
    return Counter(str(event.job_id) for event in events(store) if event.kind == "succeeded")


def events(store: Store) -> Iterator[Any]:
    """All events of a store."""
    after = 0
    while page := store.all_events(after=after, limit=PAGE):
        yield from page
        after = page[-1].number


def registered_once(store: Store, sweeps: list[str]) -> list[str]:
    """Runs that succeeded, were registered once, and have one answer."""
    counts = registrations(store)
    return [
        run.id
        for run in runs(store, sweeps).values()
        if run.state is State.SUCCEEDED
        and counts[run.id] == 1
        and [file.name for file in store.run_files(run.id)].count(RESULT) == 1
    ]


def files(store: Store) -> list[Stored]:
    """Every file that a row names."""
    listed: list[Stored] = []
    after = ("", "")
    while page := store.files(after=after, limit=PAGE):
        listed += [file for _, file in page]
        after = page[-1][0], page[-1][1].name
    return listed


def damaged(store: Store, artifacts: Artifacts) -> list[str]:
    """Registered files that are missing, or not what their rows say."""
    return [file.path for file in files(store) if not artifacts.is_intact(file)]


def resumed(store: Store, artifacts: Artifacts, sweeps: list[str]) -> list[str]:
    """Runs whose answer says that they went on from a checkpoint."""
    answers = {
        id: file
        for id in runs(store, sweeps)
        for file in store.run_files(id)
        if file.name == RESULT and artifacts.is_intact(file)
    }
    return [
        id for id, file in answers.items() if " step " in str(artifacts.read_json(file)["provenance"].get("checkpoint"))
    ]


def half_files(store: Store, artifacts: Artifacts) -> list[str]:
    """Unfinished files, by name or by content, among those that could be used or shown."""
    counting = _folders_that_count(store, artifacts)
    parts = [part for folder in counting for part in folder.glob(f".{PART}")]
    final = [file for folder in counting for file in folder.glob("*.*")]
    final += [*artifacts.root.glob(f"{RUNS}/*/*/{CHECKPOINT}.npz"), *_cached(artifacts)]
    return [str(file) for file in [*parts, *(file for file in final if not is_whole(file))]]


def _folders_that_count(store: Store, artifacts: Artifacts) -> list[Path]:
    """Those of registered files, and those that would be registered at the next look."""
    registered = {artifacts.path(file).parent for file in files(store)}
    complete = {artifacts.attempt_directory(claim) for claim in store.leases() if artifacts.complete_files(claim)}
    return sorted(registered | complete)


def _cached(artifacts: Artifacts) -> list[Path]:
    """Partial cubes, which are sent again to whoever asks the same."""
    return [file for file in artifacts.root.glob(f"{CACHE}/*.*") if not file.match(PART)]


def is_whole(file: Path) -> bool:
    """Whether a file can be read to its end; one that has gone meanwhile counts for nothing."""
    try:
        return _reads_to_its_end(file)
    except FileNotFoundError:
        return True
    except (OSError, ValueError, EOFError, BadZipFile, zlib.error):
        return False


def _reads_to_its_end(file: Path) -> bool:
    content = file.read_bytes()
    if content.startswith(b"PK"):
        with ZipFile(file) as arrays:
            return arrays.testzip() is None
    if content.startswith(b"\x89HDF"):
        with xr.open_dataset(file) as cube:
            cube.load()
        return True
    if content.startswith(b"<"):
        return content.rstrip().endswith(b"</html>")
    if file.suffix == ".csv" and content.endswith(b"\n"):
        return True
    # A log ends anywhere; a final state of a stand-in is the id of its run, and words.
    if file.suffix == ".txt" or ID.match(content.decode()):
        return True
    json.loads(content)
    return True


def contradictions(store: Store) -> list[str]:
    """What rows say against each other."""
    listed = _broken_file(store)
    try:
        nobody_waits_in_vain(store)
    except AssertionError as error:
        listed.append(f"somebody waits in vain: {error}")
    for row in _sweeps(store):
        if sum(row.counts.values()) != row.planned or row.reused + row.new != row.planned:
            listed.append(f"{row.name}: points do not add up")
    return listed


def _sweeps(store: Store) -> Sequence[SweepStatus]:
    return store.sweeps(limit=PAGE).items


def _broken_file(store: Store) -> list[str]:
    """What SQLite finds in its own file."""
    if not store._database.is_sqlite:
        return []
    listed: list[str] = []
    with store._database.reading() as connection:
        for check in ("PRAGMA integrity_check", "PRAGMA foreign_key_check"):
            listed += [str(row) for row in connection.exec_driver_sql(check) if row != ("ok",)]
    return listed


def differences(expected: Path, got: Path, *, at: Mapping[str, Any] | None = None) -> Iterator[str]:
    """Variables of two cubes, or of a part of both, that differ in a bit, or are in one only."""
    with xr.open_dataset(expected) as whole, xr.open_dataset(got) as other:
        first, second = whole.sel(at or {}), other.sel(at or {})
        for name in sorted({*map(str, first.variables), *map(str, second.variables)}):
            if name not in first.variables or name not in second.variables:
                yield f"{name} is in one of them only"
            elif not _same_bits(first[name], second[name]):
                yield name


def count_variables(file: Path) -> int:
    """The number of variables that are compared."""
    with xr.open_dataset(file) as cube:
        return len(cube.variables)


def _same_bits(first: xr.DataArray, second: xr.DataArray) -> bool:
    if first.dims != second.dims or first.shape != second.shape:
        return False
    if first.dtype.kind == second.dtype.kind and first.dtype.kind in TEXT_KINDS:
        return bool(np.array_equal(first.values, second.values))
    return first.dtype == second.dtype and first.values.tobytes() == second.values.tobytes()
