"""Bodies and heads that are made to cost much: they cost little, and nobody else waits for them."""

import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import httpx
import psutil

from tests.acceptance.support import slow_clients
from tests.acceptance.support.costly_bodies import BODIES, CostlyBody
from tests.acceptance.support.liveness import LivenessProbe, probing
from tests.acceptance.support.serving import Service
from tests.rows import Row, at_most
from tests.service.support.api import SWEEP

IDLE = {"WHIPPLE_TARGETS_MODULE": "tests.service.support.targets", "WHIPPLE_WORKERS": "1"}
ROUTES = (("POST", "/v1/sweeps"), ("POST", "/v1/sweeps/estimate"), ("PATCH", "/v1/sweeps/none"))
REFUSALS = {413, 415, 422}
MOST_BYTES, MOST_FINDINGS = 64 * 1024, 50  # of an answer to a bad body
PATIENCE_SECONDS = 30.0
PAUSE_SECONDS = 0.5  # between two requests of one sender
LONGEST_ANSWER = 150.0  # s; a child has 120 for a sweep
HEADER = 200 << 20  # bytes
# Half-sent heads: more than may be connected, and fewer than a process may open.
HALVES = (510, 900)
CHUNKS = 1_000_000
GRACE_SECONDS = 2.0  # after a deadline


@dataclass(frozen=True)
class AnswerLimits:
    """What an answer may take, s."""

    refusal: float = 1.0  # computing time of the service and its children
    live: float = 0.5  # wait for an answer to somebody else


# Beside other tests on two cores; without the cures, bodies took 5 to 80 s and heads all time there is.
BUSY = AnswerLimits(refusal=4.0, live=3.0)


@contextmanager
def served(program: tuple[str, ...] = ("-m", "service")) -> Iterator[Service]:
    """A service that has answered before: its first answer loads what all others use."""
    with tempfile.TemporaryDirectory(prefix="whipple-bodies-") as place:
        service = Service(Path(place) / "data", IDLE, program=program)
        service.start()
        try:
            service.wait_until_ready()
            answer = httpx.post(f"{service.url}/v1/sweeps/estimate", json=SWEEP, timeout=60)
            assert answer.status_code == 200, answer.text
            yield service
        finally:
            service.kill()


def refused(service: Service, names: Iterable[str], limits: AnswerLimits = AnswerLimits()) -> Iterator[Row]:
    """Each body is sent wherever a document is taken."""
    with httpx.Client(base_url=service.url, timeout=PATIENCE_SECONDS) as client, probing(service.port) as probe:
        for name in names:
            yield _row_of_answers(name, list(_answers(client, BODIES[name], service)), limits)
    yield from _rows_of_others("bad bodies", probe, limits)


def closed(
    service: Service, header: int, halves: Iterable[int], seconds: float, limits: AnswerLimits = AnswerLimits()
) -> Iterator[Row]:
    """A header of so many bytes, then so many half-sent heads with a slow client among them."""
    with probing(service.port) as probe:
        sent = slow_clients.send_header(service.port, header)
    yield Row(f"bytes taken of a header of {header}", f"fewer than {header}", sent, sent < header)
    yield from _rows_of_others("a header without end", probe, limits)
    for count in halves:
        with probing(service.port) as probe, slow_clients.half_sent(service.port, count) as clients:
            text = slow_clients.send_slowly(service.port, seconds / 2).decode()
            left = slow_clients.still_open(clients, seconds / 2 + GRACE_SECONDS)
        yield Row(f"a slow client among {count}", "HTTP/1.1 200 OK", text, text.endswith("200 OK"))
        yield Row(f"of {count} half-sent heads, open after {seconds:g} s", 0, left, left == 0)
        yield from _rows_of_others(f"{count} half-sent heads", probe, limits)


def pipelined(service: Service, count: int, seconds: float, limits: AnswerLimits = AnswerLimits()) -> Iterator[Row]:
    """Many connections that send requests without reading the responses hold nobody up."""
    with probing(service.port) as probe, slow_clients.pipelining(service.port, count, "/docs"):
        time.sleep(seconds)
    yield from _rows_of_others(f"{count} pipelining connections", probe, limits)


@dataclass(frozen=True)
class Flood:
    """Requests at once, again and again: estimates with one key and submissions with another."""

    estimates: int
    submissions: int
    seconds: float


def flooded(
    service: Service,
    secrets: Mapping[str, str],
    documents: Sequence[Mapping[str, Any]],
    flood: Flood,
    limits: AnswerLimits = AnswerLimits(),
) -> Iterator[Row]:
    """Large sweeps in number leave the service alive, ready and small; ``secrets`` of read, submit and other."""
    end = time.monotonic() + flood.seconds
    answered: Counter[int | str] = Counter()
    before = peak = _memory(service)
    slowest = {"/readyz": 0.0, "/v1/sweeps": 0.0}
    statuses: dict[str, Counter[int]] = {path: Counter() for path in slowest}

    def send(number: int) -> None:
        is_estimate = number < flood.estimates
        path = "/v1/sweeps/estimate" if is_estimate else "/v1/sweeps"
        headers = {"Authorization": f"Bearer {secrets['read' if is_estimate else 'submit']}"}
        with httpx.Client(base_url=service.url, timeout=LONGEST_ANSWER, headers=headers) as client:
            while time.monotonic() < end:
                try:
                    status = client.post(path, json=documents[number % 2]).status_code
                    answered[status] += 1
                except httpx.TransportError as error:
                    answered[type(error).__name__] += 1
                time.sleep(PAUSE_SECONDS)

    count = flood.estimates + flood.submissions
    other = {"Authorization": f"Bearer {secrets['other']}"}
    with (
        ThreadPoolExecutor(count) as senders,
        probing(service.port) as probe,
        httpx.Client(base_url=service.url, timeout=PATIENCE_SECONDS, headers=other) as client,
    ):
        sent = [senders.submit(send, number) for number in range(count)]
        while not all(each.done() for each in sent):
            for path in slowest:
                begin = time.monotonic()
                statuses[path][client.get(path).status_code] += 1
                slowest[path] = max(slowest[path], time.monotonic() - begin)
            peak = max(peak, _memory(service))
            time.sleep(PAUSE_SECONDS)
    yield from _rows_of_others(f"{count} large sweeps at once", probe, limits)
    for path, codes in statuses.items():
        yield Row(f"answers of {path}", "200", str(dict(codes)), set(codes) == {200})
    yield at_most("slowest list of sweeps of another key (s)", limit=1.0, got=slowest["/v1/sweeps"])
    yield at_most("more memory than at the start (MB)", limit=400.0, got=(peak - before) / 1e6)
    odd = {status for status in answered if status not in (200, 202, 429)}
    yield Row("answers to the large sweeps", "200, 202 or 429", str(dict(answered)), not odd)
    done = answered[200] * answered[202]
    yield Row("large sweeps that were estimated and accepted", "some of each", done, done > 0)


def _memory(service: Service) -> float:
    """Bytes of memory of a service and its children; a page that they share counts once."""
    return sum(_of_each(service, lambda process: process.memory_full_info().pss))


def _computing_time(service: Service) -> float:
    """Processor seconds of a service and its children so far, with those of children that ended."""
    return sum(_of_each(service, lambda process: sum(process.cpu_times()[:4])))


def _of_each(service: Service, read: Callable[[psutil.Process], float]) -> Iterator[float]:
    assert service.process is not None
    parent = psutil.Process(service.process.pid)
    for process in (parent, *parent.children()):
        with suppress(psutil.NoSuchProcess):  # it has ended
            yield read(process)


def chunked(service: Service, limits: AnswerLimits = AnswerLimits()) -> Iterator[Row]:
    """A body of chunks of one byte holds nobody up."""
    with probing(service.port) as probe:
        slow_clients.send_chunks(service.port, CHUNKS)
    yield from _rows_of_others(f"{CHUNKS} chunks of one byte", probe, limits)


def dribbled(service: Service, seconds: float) -> Row:
    """A body that comes byte by byte is waited for so long."""
    got = slow_clients.dribble(service.port, seconds + 2 * GRACE_SECONDS)
    expected = f"{seconds:g} and {GRACE_SECONDS:g} more"
    passed = seconds - 1.0 <= got <= seconds + GRACE_SECONDS
    return Row("a body byte by byte, waited for (s)", expected, got, passed)


@dataclass(frozen=True)
class RequestCost:
    """What was answered to a body."""

    seconds: float  # of computing
    status: int
    bytes: int
    findings: int  # that are told
    more: int  # that are counted alone

    def is_cheap(self, limits: AnswerLimits) -> bool:
        return (
            self.status in REFUSALS
            and self.seconds <= limits.refusal
            and self.bytes <= MOST_BYTES
            and (self.findings < MOST_FINDINGS or (self.findings == MOST_FINDINGS and self.more > 0))
        )


def _answers(client: httpx.Client, body: CostlyBody, service: Service) -> Iterator[RequestCost]:
    content = body.make()
    for method, path in ROUTES:
        before = _computing_time(service)
        headers = {"Content-Type": body.media_type}
        response = client.request(method, path, content=content, headers=headers)
        seconds = _computing_time(service) - before
        problem = response.json()
        findings, more = len(problem.get("errors", ())), problem.get("more_errors", 0)
        yield RequestCost(seconds, response.status_code, len(response.content), findings, more)


def _row_of_answers(name: str, answers: list[RequestCost], limits: AnswerLimits) -> Row:
    text = ", ".join(
        f"{cost.status} after {cost.seconds:.2f} s ({cost.bytes} B, {cost.findings} + {cost.more})" for cost in answers
    )
    limit = f"each refused in {limits.refusal:g} s of computing ({MOST_BYTES} B, {MOST_FINDINGS} findings)"
    return Row(name, limit, text, all(cost.is_cheap(limits) for cost in answers))


def _rows_of_others(name: str, probe: LivenessProbe, limits: AnswerLimits) -> Iterator[Row]:
    asked = len(probe.statuses)
    yield at_most(f"{name}: slowest of {asked} other answers (s)", limit=limits.live, got=probe.slowest)
    odd = probe.refusals()
    yield Row(f"{name}: other answers that are not 200", "none", odd or "none", asked > 0 and not odd)
