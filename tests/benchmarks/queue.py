"""``make bench``: what the queue costs beside the work that it gives out.

Figures are of this machine at this moment: read them when nothing else is at work. The aims are those of the design.
"""

import asyncio
import json
import statistics
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory

from tests.service.support import inspection
from tests.service.support.crash_test import WORKERS, CrashTest, Work, crash_test
from tests.service.support.databases import postgresql_server
from tests.service.support.fakes import wait_until
from tests.service.support.serving import Service

OVERHEAD_AIM = 0.03  # s a run, beside its attempt
SHORT = 200  # runs
SUBMISSIONS, SUBMITTERS = 100, 8
LOOKS_AT_ONCE, CONNECTIONS = 2000, 64
# Both cores are the runs': with a question to the store every 20 ms the looking on took an eighth of a core.
PAUSE = 1.0  # s between looks whether all is done; times are those of the events
END_SECONDS = 1800.0


def main() -> None:
    slot, attempt = overhead()
    print(
        f"a run that does nothing: {slot:.3f} s of a slot ({WORKERS / slot:.0f} runs a second), {attempt:.3f} s of them"
    )
    print(f"its attempt: {slot - attempt:.3f} s beside it (aim {OVERHEAD_AIM} s)")
    for count in (1, 2):
        for what, rate in _rates(count).items():
            print(f"{what} a second, {count} services on postgresql: {rate:.0f}")


def overhead() -> tuple[float, float]:
    """Seconds of a slot that a run costs which writes its result alone, and those of its attempt."""
    with _computed(Work(SHORT // 2, 1, targets="tests.service.support.targets", run_seconds=0.0)) as here:
        [row] = here.store.sweeps.page().items
        runs = inspection.runs(here.store, [row.id]).values()
        return _seconds_of_runs(here) * WORKERS / SHORT, statistics.fmean(run.seconds or 0.0 for run in runs)


def _rates(count: int) -> dict[str, float]:
    """Requests a second of so many services: submissions, then the state of a sweep and the list of them.

    Connections are kept, and shared evenly by the services, as a proxy shares them.
    """
    with ExitStack() as ends:
        folder = Path(ends.enter_context(TemporaryDirectory()))
        url = ends.enter_context(ends.enter_context(postgresql_server()).database())
        here = ends.enter_context(crash_test(Work(2, 1), folder, database_url=url, count=count))
        [*_] = map(Service.wait_until_ready, here.services)
        ports = [service.port for service in here.services]
        here.store.queue.pause()
        bodies = [json.dumps(document) for document in Work(2, SUBMISSIONS).documents()]
        rates = {"submissions": _rate(ports, [("POST", "/v1/sweeps", body) for body in bodies], SUBMITTERS)}
        sweep = here.store.sweeps.page().items[0].id
        for what, path in {"states of a sweep": f"/v1/sweeps/{sweep}", "lists of sweeps": "/v1/sweeps"}.items():
            rates[what] = _rate(ports, [("GET", path, "")] * LOOKS_AT_ONCE, CONNECTIONS)
        return rates


def _rate(ports: Sequence[int], requests: Sequence[tuple[str, str, str]], connections: int) -> float:
    """Requests a second, sent one after the other by each of so many connections."""
    waiting = deque(requests)

    async def send(port: int) -> None:
        reader, writer = await asyncio.open_connection("127.0.0.1", port)
        while waiting:
            method, path, body = waiting.popleft()
            head = f"{method} {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Type: application/json\r\n"
            writer.write(f"{head}Content-Length: {len(body)}\r\n\r\n{body}".encode())
            answer = (await reader.readuntil(b"\r\n\r\n")).decode().lower()
            assert answer.split()[1] in ("200", "202"), answer
            await reader.readexactly(int(answer.partition("content-length:")[2].split()[0]))
        writer.close()

    async def send_all() -> None:
        await asyncio.gather(*(send(ports[number % len(ports)]) for number in range(connections)))

    return len(requests) / _seconds(lambda: asyncio.run(send_all()))


def _seconds(act: Callable[[], object]) -> float:
    begin = time.perf_counter()
    act()
    return time.perf_counter() - begin


@contextmanager
def _computed(work: Work) -> Iterator[CrashTest]:
    """A sweep that is done, and the service that computed it."""
    with TemporaryDirectory() as folder, crash_test(work, Path(folder)) as here:
        here.service.wait_until_ready()
        [id] = here.submit()
        wait_until(lambda: here.store.sweeps.get(id).is_terminal, seconds=END_SECONDS, pause=PAUSE)
        yield here


def _seconds_of_runs(here: CrashTest) -> float:
    """From the first result to the last, as if the first had taken as long as the others."""
    [row] = here.store.sweeps.page().items
    runs = set(inspection.runs(here.store, [row.id]))
    times = [
        event.time for event in inspection.events(here.store) if event.kind == "succeeded" and event.job_id in runs
    ]
    gaps = len(times) - WORKERS
    return (times[-1] - times[WORKERS - 1]).total_seconds() * len(times) / gaps


if __name__ == "__main__":
    main()
