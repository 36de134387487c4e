"""What goes wrong around a service or within a run: the named state, and neighbours that notice nothing."""

import json
import os
import shutil
import sqlite3
import subprocess
from collections import Counter
from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

from service.records.jobs import Cause
from studies.quantities.files import write_text
from tests.claims.marked import Compared, in_full
from tests.claims.rows import Row, equal
from tests.service.support import inspection
from tests.service.support.altered_serve import BRIEF
from tests.service.support.crash_test import CrashTest, KillMoment, Work, crash_test, undisturbed
from tests.service.support.databases import postgresql_server
from tests.service.support.fakes import wait_until
from tests.service.support.processes import unmarked
from tests.service.support.targets import FAILING

WORK = Work(speeds=2, sweeps=1, thicknesses=1, run_seconds=1.0)
# Runs that are still computing when the disk is full, or the clock is set, however late that is.
LONG = replace(WORK, run_seconds=3.0)
ONE_WORKER = {"WHIPPLE_WORKERS": "1"}  # each takes seconds of computing to start
# The limit of time is that of a publication too, on a busy machine.
LIMITS = {"WHIPPLE_MEMORY_LIMIT": "1GiB", "WHIPPLE_RUN_SECONDS_LIMIT": "60"}
FAILURES = {3000: ("greedy", Cause.MEMORY_LIMIT), 3100: ("abort", Cause.CRASH), 3200: ("deaf", Cause.TIME_LIMIT)}
DISK, RESERVE = 128 << 20, 32 << 20  # bytes of a file system of its own, and what is to stay free
LOOKS = 5  # turns of the dispatcher
STEP = 1 << 20  # bytes; a tenth of it changes what the dispatcher says of the room that it sees
DAY = 86_400
PATIENCE = 120.0  # s


def service_program() -> dict[str, Any]:
    """A service whose times are its own in full, and brief in short."""
    return {} if in_full() else {"program": BRIEF}


@pytest.mark.claim("queue", "troubles-of-runs", minutes=0.5)
def test_runs__that_fail_have_the_named_end_and_no_neighbour(tmp_path: Path, compared: Compared) -> None:
    """A run that allocates without end, never ends, or crashes the interpreter has the named end, and no neighbour."""
    work = replace(WORK, speeds=len(FAILURES) + 3, run_seconds=0.2)
    behaviours = json.dumps({speed: behaviour for speed, (behaviour, _) in FAILURES.items()})
    with crash_test(work, tmp_path, settings={**LIMITS, FAILING: behaviours}) as here:
        ids = here.submit()
        here.wait_for_the_end(ids)
        runs = {round(float(point.coordinates["speed"])): point.run for point in here.store.sweeps.points(ids[0]).items}
        for speed, (_, cause) in FAILURES.items():
            run = runs.pop(speed)
            compared(equal(f"{speed} m/s: {run.reason}", expected=cause, got=run.cause))
        once = sum(run.attempt == 1 and run.crashes == 0 and run.cause is None for run in runs.values())
        compared(equal("neighbours done at the first attempt", expected=len(runs), got=once))
        [cube] = here.fetch(ids, tmp_path / "cubes")
        compared(*_rows_of_neighbours(undisturbed(work)[0], cube, FAILURES))
        compared(here.row_of_processes())


@pytest.mark.claim("queue", "trouble-locked", minutes=0.3)
@pytest.mark.claim("mend", "locked-database", minutes=0.3)
def test_database__that_another_program_locks_loses_nothing(tmp_path: Path, compared: Compared) -> None:
    """A database that another program locks: refused with a reason, nothing lost."""
    with crash_test(WORK, tmp_path, settings=ONE_WORKER, **service_program()) as here:
        ids = here.submit()
        here.wait_until_computing()
        with closing(sqlite3.connect(here.service.data / "whipple.db")) as other:
            other.execute("BEGIN IMMEDIATE")
            compared(*_rows_of_refusals(here, can_read=True))
            compared(*_rows_of_alarms(here, ready=0, queue_blocked=1, store_up=0, leader=0))
            other.rollback()
        compared(*_all_is_well(here, ids, tmp_path))
        compared(_row_of_repeats(here))


@pytest.mark.claim("mend", "database-removed", minutes=0.3)
def test_database__that_is_removed_loses_nothing_that_was_accepted(tmp_path: Path, compared: Compared) -> None:
    """A database removed under the service: refused and said, an end in order, whole once it is back."""
    with crash_test(WORK, tmp_path, settings=ONE_WORKER, **service_program()) as here:
        ids = here.submit()
        here.wait_until_computing()
        database, away = here.service.data / "whipple.db", here.service.data / "away"
        database.rename(away)
        compared(*_rows_of_a_lost_file(here, "was removed"))
        compared(equal("exit status of SIGTERM meanwhile", expected=0, got=here.service.leave()))
        away.rename(database)
        here.service.start()
        compared(*_all_is_well(here, ids, tmp_path))


@pytest.mark.claim("mend", "database-replaced", minutes=0.3)
def test_database__that_is_replaced_loses_nothing_that_was_accepted(tmp_path: Path, compared: Compared) -> None:
    """A database that a copy replaces under the service: refused and said, and it goes on once the file is back."""
    with crash_test(WORK, tmp_path, settings=ONE_WORKER, **service_program()) as here:
        ids = here.submit()
        here.wait_until_computing()
        database, away = here.service.data / "whipple.db", here.service.data / "away"
        older = shutil.copy(database, here.service.data / "older")
        os.link(database, away)
        os.replace(older, database)
        compared(*_rows_of_a_lost_file(here, "was replaced by another file"))
        away.replace(database)
        compared(*_all_is_well(here, ids, tmp_path))


@pytest.mark.claim("queue", "trouble-away", minutes=0.3)
def test_database__that_crashes_and_comes_back_loses_nothing(tmp_path: Path, compared: Compared) -> None:
    """A PostgreSQL server that crashes and comes back: refused with a reason, nothing lost."""
    with (
        postgresql_server() as server,
        crash_test(WORK, tmp_path, settings=ONE_WORKER, server=server) as here,
        ExitStack() as ends,
    ):
        ids = here.submit()
        here.wait_until_computing()
        ends.callback(server.start)  # so that it can be ended in order
        server.kill()
        compared(*_rows_of_refusals(here))
        compared(equal("life meanwhile: status", expected=200, got=here.service.get("/livez")))
        with unmarked():
            server.start()
        compared(*_all_is_well(here, ids, tmp_path))


@pytest.mark.claim("queue", "trouble-disk", minutes=0.3)
@pytest.mark.claim("mend", "full-disk", minutes=0.3)
def test_disk__that_is_full_loses_nothing(tmp_path: Path, compared: Compared) -> None:
    """A disk that is full: nothing is begun, nothing is lost, and it goes on when there is room."""
    settings = {**ONE_WORKER, "WHIPPLE_DISK_RESERVE": str(RESERVE)}
    with small_disk(tmp_path / "data"), crash_test(LONG, tmp_path, settings=settings, **service_program()) as here:
        ids = here.submit()
        here.wait_until_computing()
        filler = here.artifacts.root / "filler"
        before = here.store.events.last()
        _fill(filler)
        since = here.store.events.last()
        compared(*_rows_of_refusals(here, can_read=True))
        compared(*_rows_of_alarms(here, ready=0, queue_blocked=1))
        wait_until(lambda: not here.attempts.at(KillMoment.COMPUTING), seconds=PATIENCE)
        os.truncate(filler, filler.stat().st_size - RESERVE // 2)  # the store can be written to
        compared(*_rows_of_want(here, before, since, filler))
        filler.unlink()
        compared(*_all_is_well(here, ids, tmp_path))
        compared(_row_of_repeats(here))


@pytest.mark.claim("queue", "trouble-clock", minutes=0.3)
@pytest.mark.parametrize("days", [-400, 45])
def test_clock__that_is_set_loses_and_deletes_nothing(tmp_path: Path, days: int, compared: Compared) -> None:
    """A clock that is set back by 400 days or forward by 45: nothing stops or is deleted by age, which is said."""
    clock, settings = tmp_path / "clock", {**ONE_WORKER, "WHIPPLE_RETENTION_DAYS": "30"}
    write_text(clock, "0")
    with crash_test(replace(LONG, speeds=3), tmp_path, settings=settings, program=(*BRIEF[:-1], str(clock))) as here:
        ids = here.submit()
        for shift in (days * DAY, 0):
            here.wait_until_computing()
            write_text(clock, str(shift))  # in one piece: somebody always reads it
            last = here.store.events.last()
            wait_until(partial(_has_news, here, last), seconds=PATIENCE)
            if shift:
                why = wait_until(lambda: here.store.queue.status().deletion_paused, seconds=PATIENCE)
                said = f"{'forward' if days > 0 else 'back'} by {abs(days)} days"
                compared(Row("the queue says that it jumped", said, why, said in str(why)))
                compared(*_rows_of_alarms(here, deletion_paused=1))
                logged = here.service.log.read_text().count("nothing is deleted by age")
                compared(equal("lines of the log that say so", expected=1, got=logged))
        compared(*_all_is_well(here, ids, tmp_path))


def _all_is_well(here: CrashTest, ids: list[str], place: Path) -> Iterator[Row]:
    """What was accepted is done, at the first attempt, and what was refused is not there."""
    here.wait_for_the_end(ids)
    accepted = sorted(row.id for row in here.store.sweeps.page().items)
    yield equal("sweeps that were accepted", expected=sorted(ids), got=accepted)
    charged = sum(run.crashes for run in inspection.runs(here.store, ids).values())
    yield equal("crashes that runs are charged with", expected=0, got=charged)
    yield from here.rows_of_results(ids, place / "cubes", replace(here.work, run_seconds=WORK.run_seconds))
    yield here.row_of_processes()


def _rows_of_refusals(here: CrashTest, *, can_read: bool = False) -> Iterator[Row]:
    """The responses of a service whose database or disk takes nothing."""
    [another] = replace(here.work, resolution=here.work.resolution + 1).documents()  # that nobody asked for yet
    listed = here.service.get("/v1/sweeps")
    yield equal("the list of sweeps meanwhile: status", expected=200 if can_read else 503, got=listed)
    yield equal("a submission meanwhile: status", expected=503, got=here.service.post(another))
    yield equal("readiness meanwhile: status", expected=503, got=here.service.get("/readyz"))


def _rows_of_alarms(here: CrashTest, **expected: float) -> Iterator[Row]:
    """What `/metrics` says once it does; the dispatcher learns of a trouble when it waited for the database in vain."""

    def said() -> dict[str, float]:
        samples = (line.split() for line in here.service.text("/metrics").splitlines() if line.startswith("whipple_"))
        every = dict(sample for sample in samples if len(sample) == 2)
        return {name: float(every[f"whipple_{name}"]) for name in expected}

    with suppress(AssertionError):
        wait_until(lambda: said() == expected, seconds=PATIENCE)
    yield equal("what the metrics say", expected=expected, got=said())


def _row_of_repeats(here: CrashTest) -> Row:
    """Equal warnings are one line, and then a count a minute."""
    lines = [json.loads(line) for line in here.service.log.read_text().splitlines() if line.startswith("{")]
    warnings = Counter(line["message"] for line in lines if line["level"] in ("warning", "error"))
    often = {message: count for message, count in warnings.items() if count > 1 and "times more" not in message}
    return equal(f"of {len(warnings)} warnings, written more than once", expected={}, got=often)


def _rows_of_a_lost_file(here: CrashTest, says: str) -> Iterator[Row]:
    """What a service says whose database is not the file that it has open."""
    wait_until(lambda: says in here.service.log.read_text(), seconds=PATIENCE)
    yield from _rows_of_refusals(here)
    yield from _rows_of_alarms(here, ready=0, queue_blocked=1, store_up=0, leader=0)
    yield equal(f"readiness says that it {says}", expected=True, got=says in here.service.text("/readyz"))
    lines = [json.loads(line) for line in here.service.log.read_text().splitlines() if line.startswith("{")]
    own = [line["level"] for line in lines if line["logger"] == "service.queue.dispatcher" and says in line["message"]]
    yield equal("lines of the dispatcher about it", expected=["error"], got=own)


def _rows_of_neighbours(quiet: Path, got: Path, failures: Collection[int]) -> Iterator[Row]:
    """All that the cube says of the neighbours, and that it is something."""
    with xr.open_dataset(quiet) as cube:
        speeds = [speed for speed in cube.speed.values if round(float(speed)) not in failures]
        holes = cube.hole_diameter.sel(speed=speeds).values
    yield equal("neighbours without a hole", expected=0, got=int(np.isnan(holes).sum()))
    odd = list(inspection.differences(quiet, got, at={"speed": speeds}))
    yield equal(f"of {inspection.count_variables(got)} variables of the neighbours, other bits", expected=[], got=odd)


@contextmanager
def small_disk(data: Path) -> Iterator[None]:
    """A file system of its own for the data; skips a test where that is not allowed."""
    data.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", f"size={DISK}", "none", str(data)]
    if os.getuid() != 0 or subprocess.run(mount, check=False, capture_output=True).returncode:
        reason = "no file system can be mounted here: it needs root, and a container that allows it"
        pytest.fail(reason) if in_full() else pytest.skip(reason)
    try:
        yield
    finally:
        subprocess.run(["umount", "--lazy", str(data)], check=True)


def _fill(file: Path) -> None:
    """Take all the room there is."""
    with file.open("wb", buffering=0) as full:
        for size in (1 << 20, 1 << 12, 1):
            try:
                while True:
                    full.write(b"\0" * size)
            except OSError:
                continue


def _rows_of_want(here: CrashTest, before: int, since: int, filler: Path) -> Iterator[Row]:
    """What is told, and that nothing is begun, while less than the reserve is free."""
    wait_until(lambda: _bodies(here, "requeued", before), seconds=PATIENCE)
    why = wait_until(lambda: here.store.queue.status().blocked_reason, seconds=PATIENCE)
    yield Row("why nothing is begun", "the reserve", why, "the reserve is" in why)
    for _ in range(LOOKS):  # each time the dispatcher has looked it says anew how much room there is
        reason = here.store.queue.status().blocked_reason
        os.truncate(filler, filler.stat().st_size - STEP)
        wait_until(partial(_has_other_reason, here, reason), seconds=PATIENCE)
    ends = {(body["cause"], "the disk was full" in body["reason"]) for body in _bodies(here, "requeued", before)}
    yield equal("how runs ended that met it: lost, the disk was full", expected={("lost", True)}, got=ends)
    yield equal("attempts begun meanwhile", expected=0, got=len(_bodies(here, "started", since)))


def _has_other_reason(here: CrashTest, reason: str | None) -> bool:
    return here.store.queue.status().blocked_reason != reason


def _has_news(here: CrashTest, last: int) -> bool:
    return here.store.events.last() > last


def _bodies(here: CrashTest, kind: str, last: int) -> list[Mapping[str, Any]]:
    """What events of a kind say that happened since."""
    return [event.body for event in inspection.events(here.store) if event.kind == kind and event.number > last]
