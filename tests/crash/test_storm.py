"""Kills and freezes of every process in a random order, and how long each keeps the run waiting that it met."""

import os
import random
import statistics
import time
from collections import defaultdict
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from service.records.jobs import State
from tests import samples
from tests.claims.marked import Compared, in_full
from tests.claims.rows import Row, equal
from tests.service.support import inspection
from tests.service.support.crash_test import CrashTest, KillMoment, Victim, Work, crash_test

SEED = int(os.environ.get("WHIPPLE_SEED", "20261126"))
WORK = Work(speeds=10, sweeps=1, run_seconds=0.6)  # each sweep after the first one has ten new runs
SHORT = replace(WORK, speeds=4, thicknesses=1, run_seconds=1.0)  # one sweep, for both kills
STALL_SECONDS = "3"  # a run that is frozen for longer is ended, and begins again
SHORTEST, LONGEST = 0.5, 8.0  # s, of a freeze; a leader that is silent for 6 s loses the lead on PostgreSQL
LOCAL, CLUSTER = (Victim.SERVICE, Victim.RUN), (Victim.SERVICE, Victim.RUN, Victim.WORKER, Victim.SCHEDULER)


@dataclass(frozen=True)
class Storm:
    """An engine, a database, whether files are in a bucket too, and how much of what happens to them."""

    victims: tuple[Victim, ...]
    postgresql: bool
    freezes: int
    bucket: str = ""  # what holds it, and the cluster, as features name them
    cluster: str = ""
    kills: int = 25

    def strikes(self) -> list[tuple[Victim, float]]:
        """Victims and the seconds of their freezes (0: a kill), every victim about as often, in a random order.

        In short each is killed once.
        """
        if not in_full():
            return [(victim, 0.0) for victim in self.victims]
        chance = random.Random(SEED)
        lengths = [0.0] * self.kills + [chance.uniform(SHORTEST, LONGEST) for _ in range(self.freezes)]
        listed = [(self.victims[place % len(self.victims)], length) for place, length in enumerate(lengths)]
        return chance.sample(listed, len(listed))


BUCKETS = samples.joined("BUCKETS", {"": nullcontext}, "service")
CLUSTERS = samples.joined("CLUSTERS", {"": None}, "service")
STORMS = {
    "local-sqlite": Storm(LOCAL, postgresql=False, freezes=8),
    "local-postgresql-s3": Storm((*LOCAL, Victim.DATABASE), postgresql=True, freezes=7, bucket="s3"),
    "dask-sqlite-s3": Storm(CLUSTER, postgresql=False, freezes=8, bucket="s3", cluster="dask"),
    "dask-postgresql": Storm((*CLUSTER, Victim.DATABASE), postgresql=True, freezes=7, cluster="dask"),
}


@pytest.mark.parametrize(
    "storm",
    [
        pytest.param(
            storm, marks=pytest.mark.claim("queue", "storm", minutes=4.0, short=name == "local-sqlite"), id=name
        )
        for name, storm in STORMS.items()
        if storm.bucket in BUCKETS and storm.cluster in CLUSTERS
    ],
)
def test_storm__loses_doubles_and_holds_up_nothing(
    storm: Storm, tmp_path: Path, request: pytest.FixtureRequest, compared: Compared
) -> None:
    """100 kills -9 and 30 freezes over both engines, both databases and S3 lose, double and hold up no run."""
    server = request.getfixturevalue("postgresql") if storm.postgresql else None
    cluster, settings = CLUSTERS[storm.cluster], {"WHIPPLE_STALL_SECONDS": STALL_SECONDS}
    work, moment = (WORK, KillMoment.ANY) if in_full() else (SHORT, KillMoment.CHECKPOINTED)
    settings |= {} if in_full() else {"WHIPPLE_WORKERS": "1"}  # each takes seconds of computing to start
    with (
        BUCKETS[storm.bucket](),
        crash_test(work, tmp_path, seed=SEED, cluster_in=cluster, server=server, settings=settings) as here,
    ):
        ids: list[str] = []
        took: dict[str, list[float]] = defaultdict(list)
        strikes = storm.strikes()
        for victim, seconds in strikes:
            if in_full() or not ids:
                _feed(here, ids)
            last = here.store.events.last()
            job = here.strike(victim, seconds, moment)
            begin = time.monotonic()
            here.wait_until_ended(job, last)
            took[f"{victim} {'frozen' if seconds else 'killed'}"].append(time.monotonic() - begin)
        expected = storm.kills + storm.freezes if in_full() else len(strikes)
        compared(equal(f"kills and freezes, seed {SEED}", expected=expected, got=sum(map(len, took.values()))))
        for kind, times in sorted(took.items()):
            said = f"{statistics.median(times):.1f}, {max(times):.1f}"
            compared(Row(f"{kind}, {len(times)} times: median and longest until its run had ended (s)", "", said, None))
        compared(*here.rows_of_results(ids, tmp_path / "cubes", replace(work, sweeps=len(ids))))
        compared(inspection.row_of_checkpoints(here.store, here.artifacts, ids))
        compared(here.row_of_processes())


def _feed(here: CrashTest, ids: list[str]) -> None:
    """Submit the next sweep if no more runs wait than half of those that it brings."""
    here.service.wait_until_listening()
    if here.store.queue.status().states.get(State.QUEUED, 0) <= here.work.speeds // 2:
        document = replace(here.work, sweeps=len(ids) + 1).documents()[-1]
        with here.service.client() as client:
            ids.append(client.submit(document).id)
