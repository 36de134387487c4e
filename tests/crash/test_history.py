"""What a service costs that has much history: rows that were never computed, and figures before and after ANALYZE."""

import os
import resource
import sqlite3
import statistics
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from functools import partial
from pathlib import Path

import httpx
import psutil
import pytest
import sqlalchemy as sa

from service.queue import data_identity as identity
from service.records.jobs import Scope, Scrub
from service.settings import Settings
from service.store import Store
from service.store.tables import JOBS
from tests.claims.marked import Compared
from tests.claims.rows import Row, at_most, equal, reported
from tests.service.support import history
from tests.service.support.crash_test import Work
from tests.service.support.fakes import open_store, wait_until
from tests.service.support.processes import ROOT, process_tree
from tests.service.support.serving import Service

MANY = history.History()  # 120 000 jobs, 10 000 sweeps, 350 000 files
LONG = Work(speeds=2, sweeps=1, thicknesses=1, run_seconds=3600.0)
TIMES = 7  # each figure is the middle one of so many
SUBMISSION, METRICS, LISTING = 0.3, 0.1, 2.0  # s
IDLE, IDLE_SECONDS = 0.02, 30.0  # of a core, over so many seconds


@pytest.mark.claim("mend", "history", minutes=4.0)
def test_service__with_much_history_costs_what_a_new_one_does(tmp_path: Path, compared: Compared) -> None:
    """120 000 jobs, before and after ANALYZE: a submission in 0.3 s, /metrics in 0.1 s, idle below 0.02 of a core."""
    data = tmp_path / "data"
    settings = Settings(data=data)
    data.mkdir()
    with closing(open_store(settings)) as store:
        identity.settle(settings, store)
        history.write(store, MANY)
        store.retention.note_scrub(Scrub(time.time(), whole=(time.time(), MANY.files, 0)))  # none of the files is there
        anna, ben = (store.keys.issue(name, [Scope.SUBMIT])[1] for name in ("anna", "ben"))
        compared(equal("jobs", expected=120_000, got=_jobs(store)))
        compared(equal("files", expected=350_000, got=MANY.files))
    service = Service(data, LONG.environment() | {"WHIPPLE_WORKERS": "1", "WHIPPLE_TRUST_LOOPBACK": "false"})
    for number, state in enumerate(("before ANALYZE", "after ANALYZE")):
        with process_tree():
            service.start()
            try:
                service.wait_until_listening()
                compared(*_figures(service, (anna, ben), number, state))
            finally:
                assert service.leave() == 0, service.log_tail()
        compared(_listing(data, state))
        with closing(sqlite3.connect(data / "whipple.db")) as other:
            other.execute("ANALYZE")


def _jobs(store: Store) -> int:
    with store.database.reading() as connection:
        return connection.scalar(sa.select(sa.func.count()).select_from(JOBS)) or 0


def _figures(service: Service, keys: tuple[str, str], number: int, state: str) -> Iterator[Row]:
    """The figures of a service of which one key's run is computed, and another's wait."""
    submitting: list[float] = []
    reading: list[float] = []
    with httpx.Client(base_url=service.url, timeout=60) as http:
        for place in range(2 * TIMES):
            [document] = LONG.documents()
            document["resolution"] = 4 + number + place / 100  # that nobody asked for yet
            headers = {"Authorization": f"Bearer {keys[place % 2]}"}
            answer = _timed(submitting, partial(http.post, "/v1/sweeps", json=document, headers=headers))
            assert answer.status_code == 202, answer.text
            answer = _timed(reading, partial(http.get, "/metrics", headers=headers))
            assert answer.status_code == 200, answer.text
        if number == 0:
            wait_until(lambda: 'whipple_runs{state="running"} 1.0' in http.get("/metrics", headers=headers).text)
    yield at_most(f"{state}: submission of two runs (s)", limit=SUBMISSION, got=statistics.median(submitting))
    yield reported(f"{state}: the slowest of {len(submitting)}, the first of the service (s)", max(submitting))
    yield at_most(f"{state}: /metrics (s)", limit=METRICS, got=statistics.median(reading))
    yield at_most(f"{state}: idle (cores)", limit=IDLE, got=_idle(service.pid))


def _timed(seconds: list[float], ask: Callable[[], httpx.Response]) -> httpx.Response:
    begin = time.perf_counter()
    answer = ask()
    seconds.append(time.perf_counter() - begin)
    return answer


def _idle(pid: int) -> float:
    """The part of a core that a service and its processes use while nobody asks anything."""
    begin, before = time.monotonic(), _computed(pid)
    wait_until(lambda: time.monotonic() - begin > IDLE_SECONDS, pause=1.0)
    return (_computed(pid) - before) / (time.monotonic() - begin)


def _computed(pid: int) -> float:
    """Seconds of computing of a process and of those that it started."""
    process = psutil.Process(pid)
    times = [each.cpu_times() for each in (process, *process.children(recursive=True))]
    return sum(each.user + each.system for each in times)


def _listing(data: Path, state: str) -> Row:
    """The least of three times that ``whipple retention`` computes for all sweeps: others share the memory."""
    seconds = min(_seconds_of_listing(data) for _ in range(3))
    return at_most(f"{state}: whipple retention --to-size (s of computing)", limit=LISTING, got=seconds)


def _seconds_of_listing(data: Path) -> float:
    command = [sys.executable, "-m", "service", "retention", "--to-size", "1MB", "--data", str(data)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    listed = subprocess.run(command, cwd=ROOT, env=environment, check=True, capture_output=True, text=True).stdout
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert len(listed.splitlines()) > MANY.sweeps * 0.9, listed[-500:]
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
