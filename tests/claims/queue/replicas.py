"""Several services on one database: asked the same by many at once, they compute it once."""

from collections.abc import Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from threading import Barrier
from typing import Any

import httpx

from tests.acceptance.checks.common import folder, rows_of_cubes, undisturbed
from tests.acceptance.support import inspection
from tests.acceptance.support.crash_test import Work
from tests.acceptance.support.services import Services, sharing
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
    with (
        folder() as place,
        postgresql_server() as server,
        server.database() as url,
        sharing(place, url, WORK, REPLICAS) as here,
    ):
        ids, answers = _submit(here, WORK)
        new = sorted(answer["new"] for answer in answers)
        wanted = [0] * (CLIENTS - 1) + [WORK.runs]
        yield Row(f"runs that are new to {CLIENTS} clients", wanted, new, new == wanted)
        here.wait_for_the_end(ids)
        begun = [run.attempt for run in inspection.runs(here.store, ids).values()]
        yield Row("attempts at each run", [1] * WORK.runs, begun, begun == [1] * WORK.runs)
        yield from _done(here, WORK, ids, place)

        ids, _ = _submit(here, MORE)
        wait_until(lambda: here.store.leases(), seconds=PATIENCE)
        leading = [service for service in here.services if here.leads(service)]
        yield Row("services that lead", 1, len(leading), len(leading) == 1)
        leading[0].kill()
        here.wait_for_the_end(ids)
        yield from _done(here, MORE, ids, place)
        left = here.leave()
        yield Row("processes left", 0, len(left), not left)


def _done(here: Services, work: Work, ids: list[str], place: Path) -> Iterator[Row]:
    once = inspection.registered_once(here.store, ids)
    yield Row("runs registered exactly once", work.runs, len(once), len(once) == work.runs)
    alive = next(service for service in here.services if service.is_alive())
    with alive.client() as client:
        cubes = [client.sweep(id).fetch(place / id) / "cube.nc" for id in ids]
    yield from rows_of_cubes(list(undisturbed(work)) * len(ids), cubes)


def _submit(here: Services, work: Work) -> tuple[list[str], list[Mapping[str, Any]]]:
    """Submit a sweep from all clients at the same moment, to each service in turn: sweeps, answers."""
    [document] = work.documents()
    ready = Barrier(CLIENTS)

    def ask(number: int) -> Mapping[str, Any]:
        url = here.services[number % REPLICAS].url
        ready.wait(PATIENCE)
        answer = httpx.post(f"{url}/v1/sweeps", json=document, timeout=PATIENCE)
        assert answer.status_code == 202, answer.text
        return dict(answer.json())

    with ThreadPoolExecutor(CLIENTS) as pool:
        answers = list(pool.map(ask, range(CLIENTS)))
    return sorted(answer["id"] for answer in answers), answers
