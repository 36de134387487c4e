"""What is looked at after a drill: rows, files, and every variable of every cube."""

from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from service.artifacts import PART, Artifacts
from service.jobs import ANSWER, RunRow, State, Stored, SweepRow
from service.store import Store
from tests.service.test_store_races import check as nobody_waits_in_vain

WALL_CLOCK = {"solver_seconds"}  # the only variable that may differ between two times
PAGE = 1000


def runs(store: Store, sweeps: list[str]) -> dict[str, RunRow]:
    """All runs of sweeps, each once."""
    points = (point for id in sweeps for point in store.sweep_runs(id, limit=PAGE).items)
    return {point.run.id: point.run for point in points}


def registrations(store: Store) -> Counter[str]:
    """How often each job was registered as done: events are never removed."""
    return Counter(str(event.job_id) for event in events(store) if event.kind == "succeeded")


def events(store: Store) -> Iterator[Any]:
    """All that happened."""
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
        and [file.name for file in store.run_files(run.id)].count(ANSWER) == 1
    ]


def files(store: Store) -> list[Stored]:
    """Every file that a row names."""
    found: list[Stored] = []
    after = ("", "")
    while page := store.files(after=after, limit=PAGE):
        found += [file for _, file in page]
        after = page[-1][0], page[-1][1].name
    return found


def damaged(store: Store, artifacts: Artifacts) -> list[str]:
    """Registered files that are missing, or not what their rows say."""
    return [file.path for file in files(store) if not artifacts.is_intact(file)]


def resumed(store: Store, artifacts: Artifacts, sweeps: list[str]) -> list[str]:
    """Runs whose answer says that they went on from a checkpoint."""
    answers = {
        id: file
        for id in runs(store, sweeps)
        for file in store.run_files(id)
        if file.name == ANSWER and artifacts.is_intact(file)
    }
    return [
        id
        for id, file in answers.items()
        if " step " in str(artifacts.read_json(file)["provenance"].get("checkpoint"))
    ]


def half_files(store: Store, artifacts: Artifacts) -> list[str]:
    """Unfinished files in a folder that counts."""
    folders = {artifacts.path(file).parent for file in files(store)}
    return [str(part) for folder in sorted(folders) for part in folder.glob(f".{PART}")]


def contradictions(store: Store) -> list[str]:
    """What rows say against each other."""
    found = _broken_file(store)
    try:
        nobody_waits_in_vain(store)
    except AssertionError as error:
        found.append(f"somebody waits in vain: {error}")
    for row in _sweeps(store):
        if sum(row.counts.values()) != row.planned or row.reused + row.new != row.planned:
            found.append(f"{row.name}: points do not add up")
    return found


def _sweeps(store: Store) -> Sequence[SweepRow]:
    return store.sweeps(limit=PAGE).items


def _broken_file(store: Store) -> list[str]:
    """What SQLite finds in its own file."""
    if not store._database.is_sqlite:
        return []
    found: list[str] = []
    with store._database.reading() as connection:
        for words in ("PRAGMA integrity_check", "PRAGMA foreign_key_check"):
            found += [str(row) for row in connection.exec_driver_sql(words) if row != ("ok",)]
    return found


def differences(one: Path, other: Path) -> Iterator[str]:
    """Variables of two cubes that differ in a bit, or are in one of them only."""
    with xr.open_dataset(one) as first, xr.open_dataset(other) as second:
        for name in sorted({*map(str, first.variables), *map(str, second.variables)} - WALL_CLOCK):
            if name not in first.variables or name not in second.variables:
                yield f"{name} is in one of them only"
            elif not _same_bits(first[name], second[name]):
                yield name


def count_variables(file: Path) -> int:
    """Those that are compared."""
    with xr.open_dataset(file) as cube:
        return len({*map(str, cube.variables)} - WALL_CLOCK)


def _same_bits(one: xr.DataArray, other: xr.DataArray) -> bool:
    first, second = one.values, other.values
    if one.dims != other.dims or first.dtype != second.dtype or first.shape != second.shape:
        return False
    if first.dtype == object:
        return bool(np.array_equal(first, second))
    return first.tobytes() == second.tobytes()
