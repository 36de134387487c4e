"""What goes wrong around a service or within a run: the named state, and neighbours that notice nothing."""

import os
import sqlite3
import subprocess
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from service.records.jobs import Cause
from studies.values.files import write_text
from tests.acceptance.checks.common import fetch, folder, rows_of_cubes, rows_of_store, undisturbed
from tests.acceptance.support import inspection, outage
from tests.acceptance.support.crash_test import CrashTest, Work, crash_test
from tests.acceptance.support.faults import KillMoment
from tests.rows import Row
from tests.service.support.fakes import wait_until

Check = Callable[[], Iterator[Row]]

WORK = Work(speeds=6, sweeps=1, thicknesses=1, run_seconds=1.0)
# Runs that are still computing when the disk is full, or the clock is set, however late that is.
LONG = replace(WORK, run_seconds=3.0)
TROUBLED = replace(WORK, targets="tests.acceptance.support.failing_runs", run_seconds=0.2)
LIMITS = {"WHIPPLE_MEMORY_LIMIT": "1GiB", "WHIPPLE_RUN_SECONDS_LIMIT": "10"}
CAUSES = {3000.0: Cause.MEMORY_LIMIT, 3100.0: Cause.TIME_LIMIT, 3200.0: Cause.CRASH}  # by speed
DISK, RESERVE = 128 << 20, 32 << 20  # bytes of a file system of its own, and what is to stay free
LOOKS = 5  # turns of the dispatcher
STEP = 1 << 20  # bytes; a tenth of it changes what the dispatcher says of the room that it sees
DAY = 86_400
PATIENCE = 120.0  # s


def failing_runs() -> Iterator[Row]:
    """Runs that allocate without end, never end, or crash the interpreter, beside healthy neighbours."""
    [quiet] = undisturbed(WORK)
    with folder() as place, crash_test(TROUBLED, place, settings=LIMITS) as here:
        ids = here.submit()
        here.wait_for_the_end(ids)
        points = here.store.sweep_runs(ids[0]).items
        for speed, cause in CAUSES.items():
            runs = [point.run for point in points if point.coordinates["speed"] == speed]
            got = {str(run.cause) for run in runs}
            reason = f"{speed:g} m/s: {', '.join(sorted({run.reason or '' for run in runs}))}"
            yield Row(reason, {str(cause)}, got, got == {str(cause)})
        fine = [point.run for point in points if point.coordinates["speed"] not in CAUSES]
        once = sum(run.attempt == 1 and run.crashes == 0 and run.cause is None for run in fine)
        yield Row("neighbours done at the first attempt", len(fine), once, once == len(fine))
        [cube] = fetch(here, ids, place / "cubes")
        yield from _rows_of_neighbours(quiet, cube)
        yield from _rows_of_the_end(here)


def database_locked(**more: Any) -> Iterator[Row]:
    """The rows of it; ``more`` words for the service."""
    with folder() as place, crash_test(WORK, place, **more) as here:
        ids = here.submit()
        wait_until(lambda: here.attempts.at(KillMoment.COMPUTING), seconds=PATIENCE)
        with closing(sqlite3.connect(here.service.data / "whipple.db")) as other:
            other.execute("BEGIN IMMEDIATE")
            yield from _rows_of_refusals(here, can_read=True)
            other.rollback()
        yield from _all_is_well(here, ids, place)


def database_away() -> Iterator[Row]:
    """A PostgreSQL server that crashes and comes back."""
    with outage.postgresql() as database, folder() as place, crash_test(WORK, place, database_url=database.url) as here:
        ids = here.submit()
        wait_until(lambda: here.attempts.at(KillMoment.COMPUTING), seconds=PATIENCE)
        database.stop()
        yield from _rows_of_refusals(here)
        yield _status("life meanwhile", 200, here.service.get("/livez"))
        database.start()
        yield from _all_is_well(here, ids, place)


def disk_full(**more: Any) -> Iterator[Row]:
    """The rows of it; ``more`` words for the service."""
    settings = {"WHIPPLE_DISK_RESERVE": str(RESERVE)}
    with folder() as place, _small_disk(place / "data"), crash_test(LONG, place, settings=settings, **more) as here:
        ids = here.submit()
        wait_until(lambda: here.attempts.at(KillMoment.COMPUTING), seconds=PATIENCE)
        filler = here.artifacts.root / "filler"
        before = here.store.last_event()
        _fill(filler)
        since = here.store.last_event()
        yield from _rows_of_refusals(here, can_read=True)
        wait_until(lambda: not here.attempts.at(KillMoment.COMPUTING), seconds=PATIENCE)
        os.truncate(filler, filler.stat().st_size - RESERVE // 2)  # the store can be written to
        yield from _rows_of_want(here, before, since, filler)
        filler.unlink()
        yield from _all_is_well(here, ids, place)


def _rows_of_want(here: CrashTest, before: int, since: int, filler: Path) -> Iterator[Row]:
    """What is told, and that nothing is begun, while less than the reserve is free."""
    wait_until(lambda: _bodies(here, "requeued", before), seconds=PATIENCE)
    why = wait_until(lambda: here.store.queue().blocked_reason, seconds=PATIENCE)
    yield Row("why nothing is begun", "the reserve", why, "the reserve is" in why)
    _wait_for_looks(here, filler)
    ends = {(body["cause"], "the disk was full" in body["reason"]) for body in _bodies(here, "requeued", before)}
    yield Row("how runs ended that met it: lost, the disk was full", {("lost", True)}, ends, ends == {("lost", True)})
    begun = len(_bodies(here, "started", since))
    yield Row("attempts begun meanwhile", 0, begun, begun == 0)


def _wait_for_looks(here: CrashTest, filler: Path) -> None:
    """Until the dispatcher has looked so often: each time it says anew how much room there is."""
    for _ in range(LOOKS):
        reason = here.store.queue().blocked_reason
        os.truncate(filler, filler.stat().st_size - STEP)
        wait_until(partial(_has_other_reason, here, reason), seconds=PATIENCE)


def _has_other_reason(here: CrashTest, reason: str | None) -> bool:
    return here.store.queue().blocked_reason != reason


def _bodies(here: CrashTest, kind: str, last: int) -> list[Mapping[str, Any]]:
    """What events of a kind say that happened since."""
    return [event.body for event in inspection.events(here.store) if event.kind == kind and event.number > last]


def clock_set() -> Iterator[Row]:
    """The rows of a service whose clock is set while runs are under way."""
    with folder() as place:
        clock = place / "clock"
        write_text(clock, "0")
        program = ("-m", "tests.acceptance.support.clock", str(clock))
        with crash_test(LONG, place, program=program) as here:
            ids = here.submit()
            for shift in (-DAY, DAY):
                wait_until(lambda: here.attempts.at(KillMoment.COMPUTING), seconds=PATIENCE)
                write_text(clock, str(shift))  # in one piece: somebody always reads it
                _wait_for_news(here)
            here.wait_for_the_end(ids)
            times = [event.time for event in inspection.events(here.store)]
            jump = (max(times) - min(times)).total_seconds()
            yield Row("the clock was set (s)", f"{DAY} and more", jump, jump > DAY)
            yield from _all_is_well(here, ids, place)


# --- what all of them do -------------------------------------------------------------------------


def another(work: Work) -> dict[str, object]:
    """A sweep that nobody asked for yet."""
    [document] = replace(work, resolution=work.resolution + 1).documents()
    return document


def _all_is_well(here: CrashTest, ids: list[str], place: Path) -> Iterator[Row]:
    """What was accepted is done, at the first attempt, and what was refused is not there."""
    here.wait_for_the_end(ids)
    accepted = [row.id for row in here.store.sweeps().items]
    yield Row("sweeps that were accepted", len(ids), len(accepted), sorted(accepted) == sorted(ids))
    runs = inspection.runs(here.store, ids).values()
    charged = sum(run.crashes for run in runs)
    yield Row("crashes that runs are charged with", 0, charged, charged == 0)
    yield from rows_of_store(here, ids)
    yield from rows_of_cubes(undisturbed(WORK), fetch(here, ids, place / "cubes"))
    yield from _rows_of_the_end(here)


def _rows_of_the_end(here: CrashTest) -> Iterator[Row]:
    left = here.leave()
    yield Row("processes left", 0, len(left), not left)


def _rows_of_refusals(here: CrashTest, *, can_read: bool = False) -> Iterator[Row]:
    """The answers of a service whose database or disk takes nothing."""
    sweeps = 200 if can_read else 503
    yield _status("the list of sweeps meanwhile", sweeps, here.service.get("/v1/sweeps"))
    yield _status("a submission meanwhile", 503, here.service.post(another(here.work)))
    yield _status("readiness meanwhile", 503, here.service.get("/readyz"))


def _status(what: str, expected: int, got: int | None) -> Row:
    return Row(f"{what}: status", expected, got, got == expected)


def _rows_of_neighbours(quiet: Path, got: Path) -> Iterator[Row]:
    """All that the cube says of the neighbours, and that it is something."""
    with xr.open_dataset(quiet) as cube:
        speeds = [speed for speed in cube.speed.values if round(float(speed), 3) not in CAUSES]
        holes = cube.hole_diameter.sel(speed=speeds).values
    without = int(np.isnan(holes).sum())
    yield Row("neighbours without a hole", 0, without, without == 0)
    odd = list(inspection.differences(quiet, got, at={"speed": speeds}))
    compared = inspection.count_variables(got)
    reason = ", ".join(odd) or "none"
    yield Row(f"of {compared} variables of the neighbours, other bits", "none", reason, not odd)


@contextmanager
def _small_disk(data: Path) -> Iterator[None]:
    """A file system of its own for the data; raises PermissionError where that is not allowed."""
    data.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={DISK}", "none", str(data)]
    if os.getuid() != 0 or subprocess.run(mount, check=False, capture_output=True).returncode:
        raise PermissionError("no file system can be mounted here: it needs root, and a container that allows it")
    try:
        yield
    finally:
        subprocess.run(["umount", "--lazy", str(data)], check=True)


def _wait_for_news(here: CrashTest) -> None:
    """Until something has happened."""
    last = here.store.last_event()
    wait_until(lambda: here.store.last_event() > last, seconds=PATIENCE)


def _fill(file: Path) -> None:
    """Take all the room there is."""
    with file.open("wb", buffering=0) as full:
        for size in (1 << 20, 1 << 12, 1):
            try:
                while True:
                    full.write(b"\0" * size)
            except OSError:
                continue
