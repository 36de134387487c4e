"""Kill -9 of everything that the service is made of, again and again, and nothing is lost."""

import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.acceptance.checks.common import (
    SEED,
    fetch,
    folder,
    row_of_checkpoints,
    rows_of_cubes,
    rows_of_store,
    undisturbed,
)
from tests.acceptance.support.crash_test import CrashTest, Work, crash_test
from tests.acceptance.support.faults import Victim, draw_faults, summary
from tests.rows import Row
from tests.service.support.databases import postgresql_server

SOLVER = "tests.acceptance.support.solving"


@dataclass(frozen=True)
class KillPlan:
    """What is computed, and how much is killed meanwhile."""

    work: Work
    victims: Mapping[Victim, int]
    external: bool = False  # PostgreSQL, and a scheduler that outlives the service


def full(**victims: int) -> Mapping[Victim, int]:
    """How many of each kind."""
    return {Victim(name): count for name, count in victims.items()}


FULL_WORK = Work(speeds=10, sweeps=19, targets=SOLVER)
SHORT_WORK = Work(speeds=5, sweeps=2)
FULL = KillPlan(FULL_WORK, full(run=28, service=12))
FULL_EXTERNAL = KillPlan(FULL_WORK, full(run=12, worker=10, scheduler=8, service=10), external=True)
SHORT = KillPlan(SHORT_WORK, full(run=2, service=1))
SHORT_EXTERNAL = KillPlan(SHORT_WORK, full(run=1, scheduler=1, service=1), external=True)


def crash_test_rows(plan: KillPlan, seed: int = SEED) -> Iterator[Row]:
    """A crash_test, and what is found afterwards."""
    print(f"seed {seed}", flush=True)
    begin = time.monotonic()
    expected = undisturbed(plan.work)
    with folder() as place, site(plan, place, seed) as here:
        wanted = draw_faults(seed, plan.victims, plan.work.runs)
        ids = here.submit()
        for fault in wanted:
            here.inject(fault)
        here.wait_for_the_end(ids)
        cubes = fetch(here, ids, place / "cubes")
        yield Row(
            f"kills -9, seed {seed}: {summary(here.injected)}",
            len(wanted),
            len(here.injected),
            len(here.injected) == len(wanted),
        )
        yield from rows_of_store(here, ids)
        yield row_of_checkpoints(here, ids)
        yield from rows_of_cubes(expected, cubes)
        left = here.leave()
        yield Row("processes left", 0, len(left), not left)
    yield Row("seconds, the undisturbed sweeps included", "", time.monotonic() - begin, None)


@contextmanager
def site(plan: KillPlan, place: Path, seed: int) -> Iterator[CrashTest]:
    """The service of a plan."""
    with ExitStack() as ends:
        url = None
        if plan.external:
            server = ends.enter_context(postgresql_server())
            url = ends.enter_context(server.database())
        yield ends.enter_context(crash_test(plan.work, place, seed=seed, database_url=url, external=plan.external))
