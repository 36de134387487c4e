"""Several services on one database: asked the same by many at once, they compute it once."""

from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from threading import Barrier
from typing import Any

import httpx

from service.store import Store
from tests.acceptance.checks.common import folder, rows_of_cubes, undisturbed
from tests.acceptance.support import inspection
from tests.acceptance.support.crash_test import Work
from tests.acceptance.support.process_tree import ProcessTree, process_tree
from tests.acceptance.support.serving import Service
from tests.claims import Row, claim
from tests.service.support.databases import postgresql_server
from tests.service.support.fakes import wait_until

WORK = Work(speeds=4, sweeps=1, run_seconds=0.3)
MORE = replace(WORK, resolution=5)  # other runs
REPLICAS, CLIENTS = 2, 8
PATIENCE = 240.0  # s


@claim(
    "replicas",
    says="two services on one PostgreSQL store, eight clients with the same sweep at once: computed once; the work "
    "goes on where the leader is killed",
)
def replicas() -> Iterator[Row]:
    with folder() as place, _replicas(place) as here:
        ids, answers = here.submit(WORK)
        new = sorted(answer["new"] for answer in answers)
        wanted = [0] * (CLIENTS - 1) + [WORK.runs]
        yield Row(f"runs that are new to {CLIENTS} clients", wanted, new, new == wanted)
        here.wait_for_the_end(ids)
        begun = [run.attempt for run in inspection.runs(here.store, ids).values()]
        yield Row("attempts at each run", [1] * WORK.runs, begun, begun == [1] * WORK.runs)
        yield from _done(here, WORK, ids, place)

        ids, _ = here.submit(MORE)
        wait_until(lambda: here.store.leases(), seconds=PATIENCE)
        leading = here.leader()
        yield Row("services that lead", 1, len(leading), len(leading) == 1)
        leading[0].kill()
        here.wait_for_the_end(ids)
        yield from _done(here, MORE, ids, place)
        left = here.leave()
        yield Row("processes left", 0, len(left), not left)


def _done(here: "Replicas", work: Work, ids: list[str], place: Path) -> Iterator[Row]:
    once = inspection.registered_once(here.store, ids)
    yield Row("runs registered exactly once", work.runs, len(once), len(once) == work.runs)
    cubes = [here.cube(id, place / id) for id in ids]
    yield from rows_of_cubes(list(undisturbed(work)) * len(ids), cubes)


@dataclass
class Replicas:
    """Services that share a database and a folder."""

    services: list[Service]
    tree: ProcessTree
    store: Store

    def submit(self, work: Work) -> tuple[list[str], list[Mapping[str, Any]]]:
        """Clients that ask at the same moment, every second one another service: sweeps, answers."""
        [document] = work.documents()
        ready = Barrier(CLIENTS)

        def ask(number: int) -> Mapping[str, Any]:
            url = self.services[number % REPLICAS].url
            ready.wait(PATIENCE)
            answer = httpx.post(f"{url}/v1/sweeps", json=document, timeout=PATIENCE)
            assert answer.status_code == 202, answer.text
            return dict(answer.json())

        with ThreadPoolExecutor(CLIENTS) as pool:
            answers = list(pool.map(ask, range(CLIENTS)))
        return sorted(answer["id"] for answer in answers), answers

    def wait_for_the_end(self, ids: list[str]) -> None:
        wait_until(lambda: all(self.store.sweep(id).is_terminal for id in ids), seconds=PATIENCE)

    def leader(self) -> list[Service]:
        """The service that the store names."""
        named = self.store.queue().leader or ""
        pids = {str(one.process.pid): one for one in self.services if one.process is not None}
        return [one for pid, one in pids.items() if named.endswith(f":{pid}")]

    def cube(self, id: str, place: Path) -> Path:
        """From a service that lives."""
        alive = next(one for one in self.services if one.is_alive())
        with alive.client() as client:
            return client.sweep(id).fetch(place) / "cube.nc"

    def leave(self) -> set[int]:
        """The processes that are left when all were asked to leave."""
        for one in self.services:
            if one.is_alive():
                assert one.leave() == 0, one.log_tail()
        return self.tree.left()


@contextmanager
def _replicas(place: Path) -> Iterator[Replicas]:
    """Two services that listen."""
    with ExitStack() as ends:
        url = ends.enter_context(ends.enter_context(postgresql_server()).database())
        tree = ends.enter_context(process_tree())
        environment = {**WORK.environment(), "WHIPPLE_DATABASE_URL": url}
        services = [
            Service(place / "data", environment, name=f"replica-{n}") for n in range(REPLICAS)
        ]
        for one in services:
            ends.callback(one.kill)
            one.start()
        for one in services:
            one.wait_until_listening()
        store = ends.enter_context(closing(Store.open(url, migrate=False)))
        yield Replicas(services, tree, store)
