"""Checks share undisturbed sweeps, and rows about stores and cubes."""

import functools
import importlib
import json
import os
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any

from studies.sweeps.sweep import Sweep
from studies.values.files import RESULT
from tests.acceptance.support import inspection
from tests.acceptance.support.crash_test import CrashTest, Work
from tests.rows import Row

SEED = int(os.environ.get("WHIPPLE_SEED", "20261121"))

_KEPT = ExitStack()  # folders of this program


def rows_of_store(here: CrashTest, ids: list[str]) -> Iterator[Row]:
    """Each run has its result, once, and the files that its row says."""
    wanted = here.work.runs
    once = inspection.registered_once(here.store, ids)
    yield Row("runs with exactly one registered result", wanted, len(once), len(once) == wanted)
    damaged = inspection.damaged(here.store, here.artifacts)
    files = len(inspection.files(here.store))
    yield Row(f"damaged ones of {files} registered files", 0, len(damaged), not damaged)
    halves = inspection.half_files(here.store, here.artifacts)
    yield Row("half files in folders that count", 0, len(halves), not halves)
    begun = sum(run.attempt for run in inspection.runs(here.store, ids).values())
    yield Row("attempts begun", "", begun, None)


def row_of_checkpoints(here: CrashTest, ids: list[str]) -> Row:
    """Some runs were killed after a checkpoint, and went on from it."""
    resumed = len(inspection.resumed(here.store, here.artifacts, ids))
    return Row("runs that went on from a checkpoint", "1 and more", resumed, resumed > 0)


def rows_of_cubes(expected: Sequence[Path], got: Sequence[Path]) -> Iterator[Row]:
    """Every variable has the bits that were expected, and so has the file."""
    pairs = list(zip(expected, got, strict=True))
    odd = [name for undisturbed_cube, cube in pairs for name in inspection.differences(undisturbed_cube, cube)]
    compared = sum(map(inspection.count_variables, got))
    names = ", ".join(sorted(set(odd))) or "none"
    yield Row(f"of {compared} variables in {len(got)} cubes, other bits", "none", names, not odd)
    same = sum(first.read_bytes() == second.read_bytes() for first, second in pairs)
    yield Row("cubes of equal bytes", len(pairs), same, same == len(pairs))


@functools.cache
def undisturbed(work: Work) -> tuple[Path, ...]:
    """The cubes of the same sweeps, computed here and without a service; kept until the program ends."""
    place = Path(_KEPT.enter_context(tempfile.TemporaryDirectory(prefix="whipple-undisturbed-")))
    targets = importlib.import_module(work.targets)
    answers: dict[str, Any] = {}
    cubes = []
    for number, document in enumerate(work.documents()):
        for point in Sweep.parse(document).runs():
            if point.run.id not in answers:
                folder = place / point.run.id
                folder.mkdir()
                targets.execute(targets.Run.from_json(point.run.as_json()), folder)
                answers[point.run.id] = json.loads((folder / RESULT).read_text())
        published = place / str(number)
        published.mkdir()
        cubes.append(Path(targets.publish(document, answers, published)["cube.nc"]))
    return tuple(cubes)


def fetch(here: CrashTest, ids: list[str], place: Path) -> tuple[Path, ...]:
    """Download the cubes, whose digests the client checks."""
    here.service.wait_until_listening()
    with here.service.client() as client:
        return tuple(client.sweep(id).fetch(place / id) / "cube.nc" for id in ids)


@contextmanager
def folder() -> Iterator[Path]:
    """A temporary folder."""
    with tempfile.TemporaryDirectory(prefix="whipple-crash-test-") as name:
        yield Path(name)
