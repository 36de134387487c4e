"""The crash test in its short form; the full one is a claim of the queue."""

import os
import signal
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest

from service.records.jobs import Kind
from tests.acceptance.checks import fault_points, kills
from tests.acceptance.checks.common import fetch, row_of_checkpoints, rows_of_cubes, rows_of_store, undisturbed
from tests.acceptance.support import inspection
from tests.acceptance.support.crash_test import Work, crash_test
from tests.acceptance.support.faults import Fault, KillMoment, Victim
from tests.rows import Row, at_least, check, equal
from tests.service.support.fakes import wait_until


@pytest.mark.slow
@pytest.mark.parametrize(
    "rows",
    [
        pytest.param(partial(kills.crash_test_rows, kills.SHORT), id="sqlite"),
        pytest.param(partial(kills.crash_test_rows, kills.SHORT_EXTERNAL), id="postgresql-dask"),
        pytest.param(fault_points.in_short, id="fault-points"),
        pytest.param(fault_points.of_a_copy, id="copy"),
    ],
)
def test_kill__loses_nothing(rows: Callable[[], Iterator[Row]]) -> None:
    check(rows())


@pytest.mark.claim("mend-again", "stopped-child", minutes=0.5)
def test_stop__of_a_child_ten_times_loses_and_doubles_nothing(compared: Callable[[Row], None], tmp_path: Path) -> None:
    """A child process that is stopped (SIGSTOP) is ended, and its run begins again and succeeds, ten times of ten."""
    work = Work(speeds=4, sweeps=3, run_seconds=0.8)
    expected = undisturbed(work)
    stopped: dict[str, Kind] = {}

    def stop_one() -> bool:
        has_runs = list(stopped.values()).count(Kind.RUN) == 8
        for attempt in here.attempts.at(KillMoment.ANY):
            lease = attempt.claim
            late = len(stopped) % 2 == 0 or KillMoment.CHECKPOINTED in attempt.moments
            if lease.kind is Kind.RUN and (has_runs or not late):
                continue
            if attempt.pid and lease.id not in stopped:
                os.kill(attempt.pid, signal.SIGSTOP)
                stopped[lease.id] = lease.kind
                return True
        return False

    with crash_test(work, tmp_path, settings={"WHIPPLE_STALL_SECONDS": "3"}) as here:
        ids = here.submit()
        while len(stopped) < 10:
            wait_until(stop_one, seconds=60, pause=0.01)
        here.wait_for_the_end(ids)
        bodies = [event.body for event in inspection.events(here.store)]
        stalls = sum(body.get("cause") == "stalled" for body in bodies)
        compared(at_least("attempts that were ended as stalled", limit=10, got=stalls))
        for row in rows_of_store(here, ids):
            compared(row)
        compared(row_of_checkpoints(here, ids))
        cubes = fetch(here, ids, tmp_path / "cubes")
        for row in rows_of_cubes(expected, cubes):
            compared(row)
        compared(equal("processes left", expected=0, got=len(here.leave())))


@pytest.mark.claim("mend-again", "equal-cubes", minutes=1.0)
def test_cubes__of_two_services_have_equal_bytes(compared: Callable[[Row], None], tmp_path: Path) -> None:
    """Cubes of the same sweep by two services are equal byte for byte, also after kills and with other workers."""
    work = Work(speeds=2, sweeps=1, targets=kills.SOLVER)
    cubes = []
    for number, (workers, threads) in enumerate([("1", "1"), ("2", "2")]):
        settings = {"WHIPPLE_WORKERS": workers, "WHIPPLE_THREADS": threads}
        place = tmp_path / str(number)
        place.mkdir()
        with crash_test(work, place, settings=settings) as here:
            ids = here.submit()
            if number:
                here.inject(Fault(0, Victim.RUN, KillMoment.CHECKPOINTED))
            here.wait_for_the_end(ids)
            cubes.append(fetch(here, ids, tmp_path / f"cubes-{number}"))
            compared(equal("kills", expected=number, got=len(here.injected)))
            here.leave()
    for row in rows_of_cubes(*cubes):
        compared(row)
