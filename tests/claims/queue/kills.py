"""Kill -9 of everything that the service is made of, again and again, and nothing is lost."""

import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.acceptance.blows import Victim, blows, in_words
from tests.acceptance.drill import Drill, Work, drill
from tests.claims import Row, claim
from tests.claims.queue._common import (
    SEED,
    fetch,
    folder,
    row_of_checkpoints,
    rows_of_cubes,
    rows_of_store,
    undisturbed,
)
from tests.service.support.databases import postgresql_server

SOLVER = "tests.acceptance.solving"


@dataclass(frozen=True)
class Plan:
    """What is computed, and how much is killed meanwhile."""

    work: Work
    victims: Mapping[Victim, int]
    external: bool = False  # PostgreSQL, and a scheduler that outlives the service


def full(**victims: int) -> Mapping[Victim, int]:
    """How many of each kind."""
    return {Victim(name): count for name, count in victims.items()}


FULL_WORK = Work(speeds=10, sweeps=19, targets=SOLVER)
SHORT_WORK = Work(speeds=5, sweeps=2)
FULL = Plan(FULL_WORK, full(run=28, service=12))
FULL_EXTERNAL = Plan(FULL_WORK, full(run=12, worker=10, scheduler=8, service=10), external=True)
SHORT = Plan(SHORT_WORK, full(run=2, service=1))
SHORT_EXTERNAL = Plan(SHORT_WORK, full(run=1, scheduler=1, service=1), external=True)


@claim(
    "kills-sqlite",
    says="40 kills -9 over 200 runs on SQLite: one registered result a run, with the bits of one that nobody disturbed",
)
def kills_sqlite() -> Iterator[Row]:
    yield from drilled(FULL, SEED)


@claim(
    "kills-postgresql",
    says="the same on PostgreSQL and a Dask cluster, whose workers and scheduler are killed too",
)
def kills_postgresql() -> Iterator[Row]:
    yield from drilled(FULL_EXTERNAL, SEED)


def drilled(plan: Plan, seed: int) -> Iterator[Row]:
    """A drill, and what is found afterwards."""
    print(f"seed {seed}", flush=True)
    begin = time.monotonic()
    expected = undisturbed(plan.work)
    with folder() as place, site(plan, place, seed) as here:
        wanted = blows(seed, plan.victims, plan.work.runs)
        ids = here.submit()
        for blow in wanted:
            here.strike(blow)
        here.wait_for_the_end(ids)
        cubes = fetch(here, ids, place / "cubes")
        yield Row(
            f"kills -9, seed {seed}: {in_words(here.done)}",
            len(wanted),
            len(here.done),
            len(here.done) == len(wanted),
        )
        yield from rows_of_store(here, ids)
        yield row_of_checkpoints(here, ids)
        yield from rows_of_cubes(expected, cubes)
        left = here.leave()
        yield Row("processes left", 0, len(left), not left)
    yield Row("seconds, the undisturbed sweeps included", "", time.monotonic() - begin, None)


@contextmanager
def site(plan: Plan, place: Path, seed: int) -> Iterator[Drill]:
    """The service of a plan."""
    with ExitStack() as ends:
        url = None
        if plan.external:
            server = ends.enter_context(postgresql_server())
            url = ends.enter_context(server.database())
        yield ends.enter_context(
            drill(plan.work, place, seed=seed, database_url=url, external=plan.external)
        )
