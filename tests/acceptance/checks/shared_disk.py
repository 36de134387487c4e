"""A data directory that is renamed away, and a leader that is frozen: real services on a real PostgreSQL."""

import os
import signal
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

from service.records.jobs import State
from tests.acceptance.support import inspection
from tests.acceptance.support.crash_test import Work
from tests.acceptance.support.services import Services, sharing
from tests.acceptance.support.serving import Service, http
from tests.rows import Row, at_most
from tests.service.support.fakes import wait_until

# Four runs.
WORK = Work(speeds=2, sweeps=1, targets="tests.service.support.targets", run_seconds=0.0)
SLOW = replace(WORK, run_seconds=1.0)  # some are under way when the leader is frozen
ONE_WORKER = {"WHIPPLE_WORKERS": "1"}
NOT_THERE = "the data directory is missing"
PATIENCE = 60.0  # s
REPLACED_SECONDS = 15.0  # from the freeze to a run that another service has computed


def directory_moved(place: Path, url: str) -> Iterator[Row]:
    """The check of disk-identity, in a folder and an empty database."""
    with sharing(place, url, WORK, 1, **ONE_WORKER) as here:
        service, away = here.services[0], place / "away"
        ids = [_submit(service, "first")]
        here.wait_for_the_end(ids)
        service.wait_until_ready()

        service.data.rename(away)
        ids += [_submit(service, "while it is away")]
        gone = _not_ready(service)
        yield Row("renamed away while it runs: /readyz", NOT_THERE, gone, NOT_THERE in gone)
        wait_until(lambda: here.store.queue().leader is None)
        yield from _rows_of_absence(service.data)
        away.rename(service.data)
        service.wait_until_ready()
        here.wait_for_the_end(ids)
        yield from _rows_of_results(here, ids)

        service.leave()
        service.data.rename(away)
        service.start()
        status = _status_at_start(service)
        yield Row("renamed away before the start: exit status", 1, *_same(1, status))
        tail = service.log_tail()
        yield Row("what it says", NOT_THERE, tail, f"{service.data}: {NOT_THERE}" in tail)
        yield from _rows_of_absence(service.data)
        away.rename(service.data)
        service.start()
        service.wait_until_ready()
        ids += [_submit(service, "after the start")]
        here.wait_for_the_end(ids)
        yield from _rows_of_results(here, ids)
        service.leave()


def frozen_leader(place: Path, url: str) -> Iterator[Row]:
    """The check of frozen-leader, in a folder and an empty database."""
    with sharing(place, url, SLOW, 2, **ONE_WORKER) as here:
        first, second = here.services
        leading, other = (first, second) if here.leads(first) else (second, first)
        term = here.store.queue().term
        ids = [_submit(leading, "under way")]
        wait_until(here.store.leases)

        with _frozen(leading):
            begin, last = time.monotonic(), here.store.last_event()
            ids += [_submit(other, "while it is frozen", resolution=5)]
            wait_until(lambda: _has_computed(here, last), seconds=10 * REPLACED_SECONDS)
            seconds = time.monotonic() - begin
            yield at_most("until another has computed (s)", limit=REPLACED_SECONDS, got=seconds)
            here.wait_for_the_end(ids)
        wait_until(lambda: not _says_that_it_leads(leading))
        yield Row("goes on and stands by: /readyz", 200, *_same(200, leading.get("/readyz")))
        yield Row("the other one leads", True, *_same(True, here.leads(other)))
        yield Row("terms since", 1, *_same(1, here.store.queue().term - term))

        other.leave()
        ids += [_submit(leading, "when it leads again", resolution=6)]
        here.wait_for_the_end(ids)
        yield Row("the first one leads again", True, *_same(True, here.leads(leading)))
        once = len(inspection.registered_once(here.store, ids))
        yield Row("runs registered exactly once", 3 * SLOW.runs, *_same(3 * SLOW.runs, once))
        failed = sum("Traceback" in service.log.read_text() for service in here.services)
        yield Row("logs with a traceback", 0, *_same(0, failed))
        yield Row("exit status of the first", 0, *_same(0, leading.leave()))


def _submit(service: Service, name: str, **changes: float) -> str:
    [document] = WORK.documents()
    return service.submit({**document, "name": name.replace(" ", "-"), **changes})


def _has_computed(here: Services, after: int) -> bool:
    """Whether a run has ended with a result since an event."""
    events = here.store.all_events(after=after, limit=100)
    return any(event.kind == "succeeded" for event in events)


def _rows_of_results(here: Services, ids: list[str]) -> Iterator[Row]:
    """Each run has the result of its first attempt."""
    runs = inspection.runs(here.store, ids).values()
    kept = sum(run.state is State.SUCCEEDED and run.path is not None for run in runs)
    yield Row("results that are registered", WORK.runs, *_same(WORK.runs, kept))
    begun = sum(run.attempt for run in runs)
    yield Row("attempts begun", WORK.runs, *_same(WORK.runs, begun))
    lost = sum(event.kind == "lost" for event in inspection.events(here.store))
    yield Row("results that were forgotten", 0, *_same(0, lost))


def _rows_of_absence(data: Path) -> Iterator[Row]:
    yield Row("a directory made in its place", False, *_same(False, data.exists()))


@contextmanager
def _frozen(service: Service) -> Iterator[None]:
    assert service.process is not None
    os.kill(service.process.pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(service.process.pid, signal.SIGCONT)


def _says_that_it_leads(service: Service) -> bool:
    return "whipple_leader 1.0" in http().get(f"{service.url}/metrics", timeout=30).text


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


def _same(expected: object, got: object) -> tuple[object, bool]:
    return got, got == expected
