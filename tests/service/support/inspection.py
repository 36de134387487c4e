"""Inspection after a crash test: the rows of a store, its files, and every variable of every cube."""

import json
import zlib
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from zipfile import BadZipFile, ZipFile

import numpy as np
import xarray as xr

from service.conversions.routes import CACHE
from service.files.artifacts import CHECKPOINT, ID, PART, RUNS, Artifacts
from service.records.jobs import RunRow, State, Stored
from service.store import Store
from studies.quantities.files import RESULT
from tests.claims.rows import Row, at_least, equal
from tests.service.store.test_races import check as nobody_waits_in_vain

TEXT_KINDS = "OSU"  # of arrays; text in a part is as wide as the longest of the whole
PAGE = 1000


def runs(store: Store, sweeps: list[str]) -> dict[str, RunRow]:
    """All runs of sweeps, each once."""
    points = (point for id in sweeps for point in store.sweeps.points(id, limit=PAGE).items)
    return {point.run.id: point.run for point in points}


def events(store: Store) -> Iterator[Any]:
    after = 0
    while page := store.events.all(after=after, limit=PAGE):
        yield from page
        after = page[-1].number


def registered_once(store: Store, sweeps: list[str]) -> list[str]:
    """Runs that succeeded, were registered once (events are never removed), and have one answer."""
    counts = Counter(str(event.run_id) for event in events(store) if event.kind == "succeeded")
    return [
        run.id
        for run in runs(store, sweeps).values()
        if run.state is State.SUCCEEDED
        and counts[run.id] == 1
        and [file.name for file in store.runs.files(run.id)].count(RESULT) == 1
    ]


def files(store: Store) -> list[Stored]:
    """Every file that a row names."""
    listed: list[Stored] = []
    after = ("", "")
    while page := store.retention.files(after=after, limit=PAGE):
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
        for file in store.runs.files(id)
        if file.name == RESULT and artifacts.is_intact(file)
    }
    provenances = {id: json.loads(artifacts.path(file).read_bytes())["provenance"] for id, file in answers.items()}
    return [id for id, provenance in provenances.items() if " step " in str(provenance.get("checkpoint"))]


def half_files(store: Store, artifacts: Artifacts) -> list[str]:
    """Unfinished files, by name or by content, among those that could be used or shown.

    These are in folders of registered files or of those that would be registered at the next look; checkpoints; and
    partial cubes, which are sent again to whoever asks the same.
    """
    counting = {artifacts.path(file).parent for file in files(store)}
    counting |= {artifacts.attempt_directory(lease) for lease in store.leases.held() if artifacts.complete_files(lease)}
    final = [file for folder in sorted(counting) for file in folder.glob("*.*")]
    final += artifacts.root.glob(f"{RUNS}/*/*/{CHECKPOINT}.npz")
    final += [file for file in artifacts.root.glob(f"{CACHE}/*.*") if not file.match(PART)]
    parts = [part for folder in sorted(counting) for part in folder.glob(f".{PART}")]
    return [str(file) for file in [*parts, *(file for file in final if not is_whole(file))]]


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
        with xr.open_datatree(file) as cube:
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
    """What rows say against each other, and what SQLite finds in its own file."""
    listed: list[str] = []
    if store.database.is_sqlite:
        with store.database.reading() as connection:
            for check in ("PRAGMA integrity_check", "PRAGMA foreign_key_check"):
                listed += [str(row) for row in connection.exec_driver_sql(check) if row != ("ok",)]
    try:
        nobody_waits_in_vain(store)
    except AssertionError as error:
        listed.append(f"somebody waits in vain: {error}")
    for row in store.sweeps.page(limit=PAGE).items:
        if sum(row.counts.values()) != row.planned or row.reused + row.new != row.planned:
            listed.append(f"{row.name}: points do not add up")
    return listed


def rows_of_store(store: Store, artifacts: Artifacts, ids: list[str], wanted: int) -> Iterator[Row]:
    """So many runs have their result, once, and the files that their rows say."""
    yield equal("runs with exactly one registered result", expected=wanted, got=len(registered_once(store, ids)))
    broken = damaged(store, artifacts)
    yield equal(f"damaged ones of {len(files(store))} registered files", expected=[], got=broken)
    yield equal("half files in folders that count", expected=[], got=half_files(store, artifacts))
    yield Row("attempts begun", "", sum(run.attempt for run in runs(store, ids).values()), None)


def row_of_checkpoints(store: Store, artifacts: Artifacts, ids: list[str]) -> Row:
    """Some runs were killed after a checkpoint, and went on from it."""
    return at_least("runs that went on from a checkpoint", limit=1, got=len(resumed(store, artifacts, ids)))


def rows_of_cubes(expected: Sequence[Path], got: Sequence[Path]) -> Iterator[Row]:
    """Every variable has the bits that were expected, and so has the file."""
    pairs = list(zip(expected, got, strict=True))
    odd = sorted({name for undisturbed_cube, cube in pairs for name in differences(undisturbed_cube, cube)})
    yield equal(f"of {sum(map(count_variables, got))} variables in {len(got)} cubes, other bits", expected=[], got=odd)
    same = sum(first.read_bytes() == second.read_bytes() for first, second in pairs)
    yield equal("cubes of equal bytes", expected=len(pairs), got=same)


def differences(expected: Path, got: Path, *, at: Mapping[str, Any] | None = None) -> Iterator[str]:
    """Variables of two cubes, or of a part of both, that differ in a bit, or are in one only."""
    with xr.open_datatree(expected) as whole, xr.open_datatree(got) as other:
        first, second = (_variables(cube.sel(at or {})) for cube in (whole, other))
        for name in sorted({*first, *second}):
            if name not in first or name not in second:
                yield f"{name} is in one of them only"
            elif not _same_bits(first[name], second[name]):
                yield name


def count_variables(file: Path) -> int:
    with xr.open_datatree(file) as cube:
        return len(_variables(cube))


def _variables(cube: xr.DataTree) -> dict[str, xr.Variable]:
    """The variables of all groups, by their paths."""
    return {
        f"{group.path}/{name}".lstrip("/"): each for group in cube.subtree for name, each in group.variables.items()
    }


def _same_bits(first: xr.Variable, second: xr.Variable) -> bool:
    if first.dims != second.dims or first.shape != second.shape:
        return False
    if first.dtype.kind == second.dtype.kind and first.dtype.kind in TEXT_KINDS:
        return bool(np.array_equal(first.values, second.values))
    return first.dtype == second.dtype and first.values.tobytes() == second.values.tobytes()
