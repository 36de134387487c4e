"""Bodies and heads that are made to cost much: they cost little, and nobody else waits for them."""

import time
from collections import Counter
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from typing import Any

import httpx
import psutil
import pytest

from service.api import middleware
from service.records.jobs import Scope
from service.settings import Settings
from service.store import Store
from tests.claims.marked import Compared, in_full
from tests.claims.rows import Row, absolute, at_least, at_most, equal
from tests.service.support import altered_serve, clients
from tests.service.support.api import LARGE_SWEEPS, SWEEP, sweep_of
from tests.service.support.clients import LivenessProbe, probing
from tests.service.support.costly_bodies import BODIES, CostlyBody
from tests.service.support.fakes import wait_until
from tests.service.support.serving import Service, serving

IDLE = {"WHIPPLE_TARGETS_MODULE": "tests.service.support.targets", "WHIPPLE_WORKERS": "1"}
ROUTES = (("POST", "/v1/sweeps"), ("POST", "/v1/sweeps/estimate"), ("PATCH", "/v1/sweeps/none"))
REFUSALS = {413, 415, 422}
MOST_BYTES, MOST_FINDINGS = 64 * 1024, 20  # of an answer to a bad body
PATIENCE_SECONDS = 30.0
PAUSE_SECONDS = 0.5  # between two requests of one sender
LONGEST_ANSWER = 150.0  # s; a child has 120 for a sweep
GRACE_SECONDS = 2.0  # after a deadline
# What an answer may take on a quiet machine; without the cures, bodies took 5 to 80 s and heads all time there is.
REFUSAL_SECONDS = 1.0  # computing time of the service and its children
LIVE_SECONDS = 0.5  # wait for an answer to somebody else


@contextmanager
def served(place: Path, *program: str) -> Iterator[Service]:
    """A service that has answered before: its first answer loads what all others use."""
    with serving(place / "data", *program, **IDLE) as service:
        service.wait_until_ready()
        answer = httpx.post(f"{service.url}/v1/sweeps/estimate", json=SWEEP, timeout=60)
        assert answer.status_code == 200, answer.text
        yield service


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service whose deadlines are its own in full, and short in the short form."""
    with served(tmp_path_factory.mktemp("bodies"), *(() if in_full() else altered_serve.BRIEF)) as served_here:
        yield served_here


def rows_of_others(name: str, probe: LivenessProbe) -> Iterator[Row]:
    """Others were answered meanwhile, and in full, on a quiet machine, soon."""
    asked = len(probe.statuses)
    if in_full():
        yield at_most(f"{name}: slowest of {asked} other answers (s)", limit=LIVE_SECONDS, got=probe.slowest)
    yield equal(f"{name}: other answers", expected={200}, got=set(probe.statuses))


# --- bodies -----------------------------------------------------------------------------------------


@pytest.mark.claim("api", "bad-bodies", minutes=3.0)
def test_bad_body__is_refused_cheaply(service: Service, compared: Compared) -> None:
    """Bodies of up to 4 MB that are made to cost much are refused within a second, and others answered meanwhile."""
    limit = f"each refused in {REFUSAL_SECONDS:g} s of computing ({MOST_BYTES} B, {MOST_FINDINGS} findings)"
    with httpx.Client(base_url=service.url, timeout=PATIENCE_SECONDS) as client, probing(service.port) as probe:
        for name, body in BODIES.items():
            costs = dict(_answers(client, body, service))
            compared(Row(name, limit, ", ".join(costs), all(costs.values())))
    compared(*rows_of_others("bad bodies", probe))


def _answers(client: httpx.Client, body: CostlyBody, service: Service) -> Iterator[tuple[str, bool]]:
    """What was answered to a body wherever a document is taken, and whether it was cheap."""
    content = body.make()
    for method, path in ROUTES:
        before = _computing_time(service)
        response = client.request(method, path, content=content, headers={"Content-Type": body.media_type})
        seconds, size, problem = _computing_time(service) - before, len(response.content), response.json()
        findings = len(problem.get("errors", ())) + problem.get("more_errors", 0)  # that are told, or counted alone
        said = f"{method} {path}: {response.status_code} after {seconds:.2f} s ({size} B, {findings})"
        is_small = size <= MOST_BYTES and findings <= MOST_FINDINGS
        yield said, response.status_code in REFUSALS and seconds <= REFUSAL_SECONDS and is_small


def _computing_time(service: Service) -> float:
    """Processor seconds of a service and its children so far, with those of children that ended."""
    return sum(_of_each(service, lambda process: sum(process.cpu_times()[:4])))


def _memory(service: Service) -> float:
    """Bytes of memory of a service and its children; a page that they share counts once."""
    return sum(_of_each(service, lambda process: process.memory_full_info().pss))


def _of_each(service: Service, read: Callable[[psutil.Process], float]) -> Iterator[float]:
    parent = psutil.Process(service.pid)
    for process in (parent, *parent.children()):
        with suppress(psutil.NoSuchProcess):  # it has ended
            yield read(process)


# --- heads, and what comes slowly -------------------------------------------------------------------


@pytest.mark.claim("api", "heads", minutes=1.0, short=True)
def test_heads__that_never_end_are_closed_and_others_are_served(service: Service, compared: Compared) -> None:
    """Endless heads and half-sent heads by the hundred are closed, and others are answered meanwhile."""
    # More heads than may be connected, and fewer than a process may open.
    size, counts = (200 << 20, (510, 900)) if in_full() else (20 << 20, (510,))
    seconds = middleware.HEAD_SECONDS if in_full() else altered_serve.HEAD_SECONDS
    patience = seconds / 2 + GRACE_SECONDS if in_full() else PATIENCE_SECONDS
    with probing(service.port) as probe:
        sent = clients.send_header(service.port, size)
    compared(at_most(f"bytes taken of a header of {size}", limit=size - 1, got=sent))
    compared(*rows_of_others("a header without end", probe))
    for count in counts:
        with probing(service.port) as probe, clients.half_sent(service.port, count) as connections:
            text = clients.send_slowly(service.port, seconds / 2).decode()
            left = clients.still_open(connections, patience)
        compared(equal(f"a slow client among {count}", expected="HTTP/1.1 200 OK", got=text))
        compared(equal(f"of {count} half-sent heads, open after {seconds:g} s", expected=0, got=left))
        compared(*rows_of_others(f"{count} half-sent heads", probe))


@pytest.mark.claim("api", "heads", minutes=1.0, short=True)
def test_body__that_comes_in_small_pieces_holds_nobody_up(service: Service, compared: Compared) -> None:
    """A body of chunks of one byte holds nobody up, and one that comes byte by byte is waited for so long."""
    chunks = 1_000_000 if in_full() else 20_000
    with probing(service.port) as probe:
        clients.send_chunks(service.port, chunks)
    compared(*rows_of_others(f"{chunks} chunks of one byte", probe))
    seconds = middleware.BODY_SECONDS if in_full() else altered_serve.BODY_SECONDS
    patience = seconds + 2 * GRACE_SECONDS if in_full() else PATIENCE_SECONDS
    got = clients.dribble(service.port, patience)
    compared(equal("a body byte by byte is ended by the service", expected=True, got=got < patience))
    if in_full():
        compared(absolute("a body byte by byte, waited for (s)", expected=seconds + 0.5, got=got, within=1.5))


@pytest.mark.claim("mend-again", "pipelining", minutes=0.5)
def test_pipelining__by_hundreds_without_a_key_holds_nobody_up(service: Service, compared: Compared) -> None:
    """600 connections that send requests for the documentation and read nothing hold nobody up."""
    with probing(service.port) as probe, clients.pipelining(service.port, 600, "/docs"):
        time.sleep(15.0)
    compared(*rows_of_others("600 pipelining connections", probe))


# --- large sweeps -----------------------------------------------------------------------------------

ESTIMATES, SUBMISSIONS, FLOOD_SECONDS = 64, 16, 60.0


@pytest.mark.claim("mend-again", "large-sweeps", minutes=4.0)
def test_large_sweeps__at_once_leave_the_service_alive_ready_and_small(tmp_path: Path, compared: Compared) -> None:
    """64 estimates and 16 submissions of large sweeps at once hold nobody up, and are answered or refused."""
    with served(tmp_path) as service:
        with closing(Store.open(Settings(data=service.data).url, migrate=False)) as store:
            scopes = {"read": Scope.READ, "submit": Scope.SUBMIT, "other": Scope.READ}
            keys = {name: store.keys.issue(name, [scope])[1] for name, scope in scopes.items()}
        compared(*_flooded(service, {name: {"Authorization": f"Bearer {key}"} for name, key in keys.items()}))


@pytest.mark.claim("doors", "memory-of-submissions", minutes=1.5)
def test_submissions__of_ten_thousand_runs_take_little_memory_and_give_it_back(
    tmp_path: Path, compared: Compared
) -> None:
    """Six submissions of 10 000 runs take the service and its children at most 200 MB more, half of it for good."""
    with served(tmp_path) as service, httpx.Client(base_url=service.url, timeout=LONGEST_ANSWER) as client:
        client.post("/v1/queue/pause").raise_for_status()
        start = peak = _memory(service)
        for number in range(6):
            axes = {
                "speed": {"start": f"{1000 + number} m/s", "stop": f"{10990 + number} m/s", "step": "10 m/s"},
                "cells_per_diameter": [*range(8, 18)],
            }
            with ThreadPoolExecutor(1) as sender:
                sent = sender.submit(client.post, "/v1/sweeps", json=sweep_of(axes=axes, resolution=None))
                while not sent.done():
                    peak = max(peak, _memory(service))
                    time.sleep(PAUSE_SECONDS)
            compared(equal(f"submission {number}: runs", expected=10_000, got=sent.result().json()["planned"]))
        compared(at_most("most memory above the start (MB)", limit=200.0, got=(peak - start) / 1e6))
        with suppress(AssertionError):
            wait_until(lambda: _memory(service) - start <= 100e6, seconds=PATIENCE_SECONDS)
        compared(at_most("memory above the start afterwards (MB)", limit=100.0, got=(_memory(service) - start) / 1e6))


def _flooded(service: Service, headers: dict[str, Any]) -> Iterator[Row]:
    """Requests at once, again and again: estimates with one key and submissions with another."""
    end = time.monotonic() + FLOOD_SECONDS
    answered: Counter[int | str] = Counter()
    before = peak = _memory(service)
    slowest = {"/readyz": 0.0, "/v1/sweeps": 0.0}
    statuses: dict[str, set[int]] = {path: set() for path in slowest}
    documents = [*LARGE_SWEEPS.values()]

    def send(number: int) -> None:
        path, key = ("/v1/sweeps/estimate", "read") if number < ESTIMATES else ("/v1/sweeps", "submit")
        with httpx.Client(base_url=service.url, timeout=LONGEST_ANSWER, headers=headers[key]) as client:
            while time.monotonic() < end:
                try:
                    answered[client.post(path, json=documents[number % 2]).status_code] += 1
                except httpx.TransportError as error:
                    answered[type(error).__name__] += 1
                time.sleep(PAUSE_SECONDS)

    count = ESTIMATES + SUBMISSIONS
    with (
        ThreadPoolExecutor(count) as senders,
        probing(service.port) as probe,
        httpx.Client(base_url=service.url, timeout=PATIENCE_SECONDS, headers=headers["other"]) as client,
    ):
        sent = [senders.submit(send, number) for number in range(count)]
        while not all(each.done() for each in sent):
            for path in slowest:
                begin = time.monotonic()
                statuses[path].add(client.get(path).status_code)
                slowest[path] = max(slowest[path], time.monotonic() - begin)
            peak = max(peak, _memory(service))
            time.sleep(PAUSE_SECONDS)
    yield from rows_of_others(f"{count} large sweeps at once", probe)
    for path, codes in statuses.items():
        yield equal(f"answers of {path}", expected={200}, got=codes)
    yield at_most("slowest list of sweeps of another key (s)", limit=1.0, got=slowest["/v1/sweeps"])
    yield at_most("more memory than at the start (MB)", limit=400.0, got=(peak - before) / 1e6)
    odd = {status for status in answered if status not in (200, 202, 429)}
    yield Row("answers to the large sweeps", "200, 202 or 429", str(dict(answered)), not odd)
    for status in (200, 202):
        yield at_least(f"large sweeps that were answered with {status}", limit=1, got=answered[status])
