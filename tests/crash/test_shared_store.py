"""Several services on one PostgreSQL database and one folder: who computes, who leads, and a folder that goes away."""

import os
import signal
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from threading import Barrier
from typing import Any

import httpx
import pytest

from service.records.jobs import State
from tests.claims.marked import Compared
from tests.claims.rows import Row, at_most, equal
from tests.service.support import inspection
from tests.service.support.crash_test import CrashTest, Work, crash_test
from tests.service.support.fakes import wait_until
from tests.service.support.serving import Service, http

# Four runs.
WORK = Work(speeds=2, sweeps=1, targets="tests.service.support.targets", run_seconds=0.0)
SLOW = replace(WORK, run_seconds=0.4)  # some are under way when the leader is frozen
SHARED = Work(speeds=4, sweeps=1, run_seconds=0.3)
ONE_WORKER = {"WHIPPLE_WORKERS": "1"}
NOT_THERE = "the data directory is missing"
PATIENCE = 60.0  # s
REPLACED_SECONDS = 15.0  # from the freeze to a run that another service has computed
CLIENTS = 8


@pytest.mark.claim("queue", "disk-identity", minutes=0.2)
def test_directory__that_moves_loses_no_result(tmp_path: Path, postgresql_url: str, compared: Compared) -> None:
    """A data directory that is renamed away and back, under a service or before its start, forgets no result."""
    with crash_test(WORK, tmp_path, database_url=postgresql_url, settings=ONE_WORKER) as here:
        [service], away = here.services, tmp_path / "away"
        ids = [_submit(service, "first")]
        here.wait_for_the_end(ids)
        service.wait_until_ready()

        service.data.rename(away)
        ids += [_submit(service, "while it is away")]
        gone = _not_ready(service)
        compared(Row("renamed away while it runs: /readyz", NOT_THERE, gone, NOT_THERE in gone))
        wait_until(lambda: here.store.queue.status().leader is None)
        compared(equal("a directory made in its place", expected=False, got=service.data.exists()))
        away.rename(service.data)
        service.wait_until_ready()
        here.wait_for_the_end(ids)
        compared(*_rows_of_results(here, ids))

        service.leave()
        service.data.rename(away)
        service.start()
        compared(equal("renamed away before the start: exit status", expected=1, got=_status_at_start(service)))
        tail = service.log_tail()
        compared(Row("what it says", NOT_THERE, tail, f"{service.data}: {NOT_THERE}" in tail))
        compared(equal("a directory made in its place", expected=False, got=service.data.exists()))
        away.rename(service.data)
        service.start()
        service.wait_until_ready()
        ids += [_submit(service, "after the start")]
        here.wait_for_the_end(ids)
        compared(*_rows_of_results(here, ids))


@pytest.mark.claim("queue", "frozen-leader", minutes=0.2)
def test_leader__that_is_frozen_is_replaced(tmp_path: Path, postgresql_url: str, compared: Compared) -> None:
    """A leader that is frozen (SIGSTOP) is replaced within 15 s, and stands by when it goes on."""
    with crash_test(SLOW, tmp_path, database_url=postgresql_url, settings=ONE_WORKER, count=2) as here:
        leading, other = _by_lead(here)
        term = here.store.queue.status().term
        ids = [_submit(leading, "under way")]
        wait_until(here.store.leases.held)

        with _frozen(leading):
            begin, last = time.monotonic(), here.store.events.last()
            ids += [_submit(other, "while it is frozen", resolution=5)]
            wait_until(lambda: _has_computed(here, last), seconds=10 * REPLACED_SECONDS)
            seconds = time.monotonic() - begin
            compared(at_most("until another has computed (s)", limit=REPLACED_SECONDS, got=seconds))
            here.wait_for_the_end(ids)
        wait_until(lambda: "whipple_leader 1.0" not in http().get(f"{leading.url}/metrics", timeout=30).text)
        compared(equal("goes on and stands by: /readyz", expected=200, got=leading.get("/readyz")))
        compared(equal("the other one leads", expected=True, got=_leads(here, other)))
        compared(equal("terms since", expected=1, got=here.store.queue.status().term - term))

        other.leave()
        ids += [_submit(leading, "when it leads again", resolution=6)]
        here.wait_for_the_end(ids)
        compared(equal("the first one leads again", expected=True, got=_leads(here, leading)))
        once = len(inspection.registered_once(here.store, ids))
        compared(equal("runs registered exactly once", expected=3 * SLOW.runs, got=once))
        failed = [service.name for service in here.services if "Traceback" in service.log.read_text()]
        compared(equal("logs with a traceback", expected=[], got=failed))
        compared(equal("exit status of the first", expected=0, got=leading.leave()))


@pytest.mark.claim("queue", "replicas", minutes=1.0)
def test_replicas__that_are_asked_the_same_at_once_compute_it_once(
    tmp_path: Path, postgresql_url: str, compared: Compared
) -> None:
    """Two services on one store that eight clients ask the same at once compute it once, also without their leader."""
    more = replace(SHARED, resolution=5)  # other runs
    with crash_test(SHARED, tmp_path, database_url=postgresql_url, count=2) as here:
        [*_] = map(Service.wait_until_ready, here.services)
        ids, answers = _submit_from_all(here, SHARED)
        new = sorted(answer["new"] for answer in answers)
        expected = [0] * (CLIENTS - 1) + [SHARED.runs]
        compared(equal(f"runs that are new to {CLIENTS} clients", expected=expected, got=new))
        here.wait_for_the_end(ids)
        begun = {run.attempt for run in inspection.runs(here.store, ids).values()}
        compared(equal("attempts at each run", expected={1}, got=begun))
        others, _ = _submit_from_all(here, more)
        wait_until(here.store.leases.held, seconds=PATIENCE)
        compared(equal("services that lead", expected=1, got=sum(_leads(here, each) for each in here.services)))
        _by_lead(here)[0].kill()
        here.wait_for_the_end(others)
        for work, id in ((SHARED, ids), (more, others)):
            compared(*here.rows_of_results(id, tmp_path / id[0], work))
        compared(here.row_of_processes())


def _submit(service: Service, name: str, **changes: float) -> str:
    [document] = WORK.documents()
    return service.submit({**document, "name": name.replace(" ", "-"), **changes})


def _submit_from_all(here: CrashTest, work: Work) -> tuple[list[str], list[Mapping[str, Any]]]:
    """Submit a sweep from all clients at the same moment, to each service in turn: sweeps, answers."""
    [document] = work.documents()
    ready = Barrier(CLIENTS)

    def ask(number: int) -> Mapping[str, Any]:
        url = here.services[number % len(here.services)].url
        ready.wait(PATIENCE)
        answer = httpx.post(f"{url}/v1/sweeps", json=document, timeout=4 * PATIENCE)
        assert answer.status_code == 202, answer.text
        return dict(answer.json())

    with ThreadPoolExecutor(CLIENTS) as pool:
        answers = list(pool.map(ask, range(CLIENTS)))
    return sorted({answer["id"] for answer in answers}), answers


def _leads(here: CrashTest, service: Service) -> bool:
    return (here.store.queue.status().leader or "").endswith(f":{service.pid}")


def _by_lead(here: CrashTest) -> list[Service]:
    """The service that leads, then the other one."""
    wait_until(lambda: any(_leads(here, service) for service in here.services))
    return sorted(here.services, key=lambda service: not _leads(here, service))


def _has_computed(here: CrashTest, after: int) -> bool:
    """Whether a run has ended with a result since an event."""
    return any(event.kind == "succeeded" for event in here.store.events.all(after=after, limit=100))


def _rows_of_results(here: CrashTest, ids: list[str]) -> Iterator[Row]:
    """Each run has the result of its first attempt."""
    runs = inspection.runs(here.store, ids).values()
    kept = sum(run.state is State.SUCCEEDED and run.sha256 is not None for run in runs)
    yield equal("results that are registered", expected=WORK.runs, got=kept)
    yield equal("attempts begun", expected=WORK.runs, got=sum(run.attempt for run in runs))
    lost = sum(event.kind == "lost" for event in inspection.events(here.store))
    yield equal("results that were forgotten", expected=0, got=lost)


@contextmanager
def _frozen(service: Service) -> Iterator[None]:
    os.kill(service.pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(service.pid, signal.SIGCONT)


def _not_ready(service: Service) -> str:
    """Why a service is not ready, as soon as it says so."""

    def ask() -> str | None:
        answer = http().get(f"{service.url}/readyz", timeout=30)
        return answer.json()["detail"] if answer.status_code == 503 else None

    return str(wait_until(ask, seconds=PATIENCE))


def _status_at_start(service: Service) -> int | None:
    """The exit status of a service that refuses to start; None: it is ready."""
    wait_until(lambda: not service.is_alive() or service.get("/readyz") == 200, seconds=PATIENCE)
    assert service.process is not None
    return service.process.poll()
