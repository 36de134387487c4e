"""The crash test: sweeps are submitted to services, and their processes are killed while they are computed."""

import functools
import importlib
import json
import os
import random
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Any, Protocol

from service.files.artifacts import Artifacts
from service.records.jobs import Kind, Lease, State, StoreUnavailable
from service.store import Store
from studies.quantities.files import RESULT
from studies.sweeps.sweep import Sweep
from tests.claims.rows import Row, equal
from tests.service.support import inspection
from tests.service.support.databases import Postgresql
from tests.service.support.fakes import is_gone, wait_until
from tests.service.support.processes import (
    ProcessTree,
    ShellProcess,
    family,
    kill_and_wait,
    parent_of,
    process_tree,
    unmarked,
)
from tests.service.support.serving import Service

WORKERS = 2
FASTEST = 5.0  # km/s more than the slowest
MOMENT_SECONDS = 120.0  # deadlines
END_SECONDS = 1800.0

_KEPT = ExitStack()  # folders of this program


@dataclass(frozen=True)
class Work:
    """Sweeps over speed and thickness; each shares all but one thickness with the one before."""

    speeds: int
    sweeps: int
    thicknesses: int = 2
    resolution: float = 4
    targets: str = "tests.service.support.chained"
    run_seconds: float = 0.4  # of targets that only wait

    @property
    def runs(self) -> int:
        return self.speeds * (self.sweeps + self.thicknesses - 1)

    def documents(self) -> list[dict[str, Any]]:
        return [self._document(number) for number in range(self.sweeps)]

    def environment(self) -> dict[str, str]:
        return {
            "WHIPPLE_TARGETS_MODULE": self.targets,
            "WHIPPLE_TEST_SECONDS": str(self.run_seconds),
            "WHIPPLE_WORKERS": str(WORKERS),
            "WHIPPLE_DISK_RESERVE": "0",
        }

    def _document(self, number: int) -> dict[str, Any]:
        step = min(0.1, FASTEST / self.speeds)
        speeds = [f"{3 + place * step:.6g} km/s" for place in range(self.speeds)]
        places = range(number, number + self.thicknesses)
        thicknesses = [f"{2 + place / 20:.2f} mm" for place in places]
        return {
            "name": f"crash-test-{number}",
            "scenario": "thin_plate",
            "fixed": {"projectile": "copper-ofhc", "target": "copper-ofhc", "projectile_diameter": "8 mm"},
            "axes": {"speed": speeds, "plate_thickness": thicknesses},
            "resolution": self.resolution,
        }


@functools.cache
def undisturbed(work: Work) -> tuple[Path, ...]:
    """The cubes of the same sweeps, computed here and without a service; kept until the program ends."""
    place = Path(_KEPT.enter_context(tempfile.TemporaryDirectory(prefix="whipple-undisturbed-")))
    targets = importlib.import_module(work.targets)
    answers: dict[str, Any] = {}
    cubes = []
    for number, document in enumerate(work.documents()):
        for point in Sweep.parse(document).runs():
            if point.run.id not in answers:
                folder = place / point.run.id
                folder.mkdir()
                targets.execute(targets.Run.from_json(point.run.as_json()), folder)
                answers[point.run.id] = json.loads((folder / RESULT).read_text())
        published = place / str(number)
        published.mkdir()
        cubes.append(Path(targets.publish(document, answers, published)["cube.nc"]))
    return tuple(cubes)


class Victim(StrEnum):
    RUN = "run"  # the warm process that computes it, or publishes
    WORKER = "worker"  # of a cluster
    SCHEDULER = "scheduler"  # the same
    SERVICE = "service"
    DATABASE = "database"  # the server, PostgreSQL


class KillMoment(StrEnum):
    ANY = "at random"
    COMPUTING = "computing"
    CHECKPOINTED = "checkpointed"


@dataclass(frozen=True)
class ObservedAttempt:
    """An attempt under way, and the process that works at it, if one does."""

    claim: Lease
    pid: int | None
    moments: frozenset[KillMoment]


class AttemptObserver:
    """Reads store and files for the attempts under way."""

    def __init__(self, store: Store, artifacts: Artifacts):
        self._store = store
        self._artifacts = artifacts

    def at(self, moment: KillMoment) -> list[ObservedAttempt]:
        drawn = [self._target(claim) for claim in self._store.leases.held()]
        return [attempt for attempt in drawn if moment in attempt.moments]

    def _target(self, claim: Lease) -> ObservedAttempt:
        folder = self._artifacts.attempt_directory(claim)
        pid = _pid(folder / "pid")
        moments = {KillMoment.ANY}
        if claim.state is State.RUNNING and claim.kind is Kind.RUN and pid is not None:
            has_checkpoint = self._artifacts.checkpoint(claim.id).is_file()
            moments |= {KillMoment.COMPUTING, *([KillMoment.CHECKPOINTED] if has_checkpoint else [])}
        return ObservedAttempt(claim, pid, frozenset(moments))


def _pid(file: Path) -> int | None:
    """The process that a file names, while it lives."""
    try:
        pid = int(file.read_text())
    except (OSError, ValueError):
        return None
    return None if is_gone(pid) else pid


class Cluster(Protocol):
    """Processes beside a service in which its runs are computed."""

    def start_workers(self, count: int, *, preload: str = "", **environment: str) -> ShellProcess: ...

    def restart(self, count: int, **environment: str) -> None:
        """Restart scheduler and workers that have died, as systemd does."""

    def scheduler(self) -> ShellProcess: ...

    def settings(self) -> dict[str, str]:
        """Variables of a service that computes here."""

    def end(self) -> None: ...


@dataclass
class CrashTest:
    """Services under test that share a store and a folder, and what is done to them."""

    work: Work
    services: list[Service]
    tree: ProcessTree
    store: Store
    chance: random.Random
    cluster: Cluster | None = None
    server: Postgresql | None = None  # PostgreSQL, a victim of kills and freezes
    killed: Counter[str] = field(default_factory=Counter)  # by job: processes of it that were killed

    def __post_init__(self) -> None:
        self.artifacts = Artifacts(self.service.data)
        self.attempts = AttemptObserver(self.store, self.artifacts)

    @property
    def service(self) -> Service:
        """The first service that is alive, or the first."""
        return next((service for service in self.services if service.is_alive()), self.services[0])

    def submit(self) -> list[str]:
        """Submit every sweep, the first ones with higher priority; their ids."""
        documents = enumerate(self.work.documents())
        return [self.service.submit(document, priority=number) for number, document in documents]

    def wait_until_computing(self) -> None:
        self._wait(lambda: self.attempts.at(KillMoment.COMPUTING))

    def strike(self, victim: Victim, seconds: float = 0.0, moment: KillMoment = KillMoment.ANY) -> str:
        """Kill a victim of an attempt at a moment, or freeze it for so long; the id of the job."""
        needs_process = victim in (Victim.RUN, Victim.WORKER)
        target = self._wait(lambda: self._choose(moment, needs_process=needs_process))
        if seconds:
            self._freeze(victim, target, seconds)
        else:
            self._kill(victim, target)
        return str(target.claim.id)

    def wait_until_ended(self, job: str, after: int) -> None:
        """Wait until a job has ended with its result, in an event after one."""
        ends = ("succeeded", "published")
        self._wait(lambda: any(e.run_id == job and e.kind in ends for e in self.store.events.all(after=after)))

    def wait_for_the_end(self, ids: list[str]) -> None:
        self._wait(lambda: all(self.store.sweeps.get(id).is_terminal for id in ids), seconds=END_SECONDS)

    def fetch(self, ids: list[str], place: Path) -> tuple[Path, ...]:
        """Download the cubes, whose digests the client checks."""
        self.service.wait_until_listening()
        with self.service.client() as client:
            return tuple(client.sweep(id).fetch(place / id) / "cube.nc" for id in ids)

    def rows_of_results(self, ids: list[str], place: Path, work: Work | None = None) -> Iterator[Row]:
        """Sweeps end with their results, once, and with the bits of cubes that nobody disturbed."""
        self.wait_for_the_end(ids)
        work = work or self.work
        yield from inspection.rows_of_store(self.store, self.artifacts, ids, work.runs)
        expected = undisturbed(work) * (len(ids) // work.sweeps)  # of so many who asked the same
        yield from inspection.rows_of_cubes(expected, self.fetch(ids, place))

    def rows_of_the_end(self, ids: list[str], place: Path) -> Iterator[Row]:
        """The same, and nothing is left running."""
        yield from self.rows_of_results(ids, place)
        yield self.row_of_processes()

    def row_of_processes(self) -> Row:
        """Stop everything in order, and nothing is left."""
        self.service.wait_until_listening()
        for service in self.services:
            if service.is_alive():
                assert service.leave() == 0, service.log_tail()
        if self.cluster is not None:
            self.cluster.end()
        return equal("processes left", expected=0, got=len(self.tree.left()))

    # --- inside ----------------------------------------------------------------------------------

    def _wait(self, condition: Callable[[], Any], *, seconds: float = MOMENT_SECONDS) -> Any:
        """Wait for a condition, and restart the parts of a cluster meanwhile."""

        def met() -> Any:
            self._restart_cluster()
            with suppress(StoreUnavailable):
                return condition()

        try:
            return wait_until(met, seconds=seconds)
        except AssertionError as error:
            states = dict(self.store.queue.status().states)
            raise AssertionError(f"{error}; {states}; {self.service.log_tail()}") from error

    def _restart_cluster(self) -> None:
        """Restart scheduler and workers, as systemd does; a service must be alive."""
        assert self.service.is_alive(), self.service.log_tail()
        if self.cluster is not None:
            self.cluster.restart(WORKERS, **self.work.environment())

    def _kill(self, victim: Victim, target: ObservedAttempt) -> bool:
        """Whether the victim lived until it was killed."""
        if victim is Victim.RUN:
            fell = target.pid is not None and kill_and_wait(target.pid)
            self.killed[target.claim.id] += fell
            return fell
        if victim is Victim.WORKER:
            worker = parent_of(target.pid) if target.pid and not is_gone(target.pid) else 0
            return worker in self.tree.pids() and kill_and_wait(worker)
        if victim is Victim.SCHEDULER:
            assert self.cluster is not None
            self.cluster.scheduler().kill()
            return True
        if victim is Victim.DATABASE:
            assert self.server is not None
            self.server.kill()
            with unmarked():
                self.server.start()
            return True
        self.service.kill()
        self.service.start()
        return True

    def _freeze(self, victim: Victim, target: ObservedAttempt, seconds: float) -> None:
        """Stop all processes of a victim (SIGSTOP), and let them go on."""
        if victim is Victim.RUN:
            self.killed[target.claim.id] += 1  # as stalled, if it takes long
        pids = self._pids(victim, target)
        for wish in (signal.SIGSTOP, signal.SIGCONT):
            for pid in pids:
                with suppress(ProcessLookupError):
                    os.kill(pid, wish)
            time.sleep(seconds if wish is signal.SIGSTOP else 0.0)

    def _pids(self, victim: Victim, target: ObservedAttempt) -> list[int]:
        """The processes of a victim; of a service itself alone, whose runs go on."""
        if victim is Victim.RUN:
            return [target.pid or 0]
        if victim is Victim.WORKER:
            return family(parent_of(target.pid)) if target.pid and not is_gone(target.pid) else []
        if victim is Victim.SCHEDULER:
            assert self.cluster is not None
            return family(self.cluster.scheduler().process.pid)
        if victim is Victim.DATABASE:
            assert self.server is not None
            return self.server.pids()
        return [self.service.pid]

    def _choose(self, moment: KillMoment, *, needs_process: bool) -> ObservedAttempt | None:
        """An attempt at this moment; a run that was hit before is spared: its third death is a failure."""
        attempts = self.attempts.at(moment)
        if needs_process:
            attempts = [item for item in attempts if item.pid and not self.killed[item.claim.id]]
        return self.chance.choice(attempts) if attempts else None


@contextmanager
def crash_test(
    work: Work,
    folder: Path,
    *,
    seed: int = 0,
    database_url: str | None = None,
    cluster_in: Callable[[Path, int], AbstractContextManager[Cluster]] | None = None,
    count: int = 1,
    settings: Mapping[str, str] | None = None,
    server: Postgresql | None = None,
    **more: Any,
) -> Iterator[CrashTest]:
    """A crash test of so many services on SQLite or another database, on this machine or with a cluster.

    ``settings`` are variables of the services (``WHIPPLE_...``), ``more`` fields of ``serving.Service``. With
    ``server`` the database is a new one of it, and it may be a victim.
    """
    with ExitStack() as ends:
        tree = ends.enter_context(process_tree())
        environment = {**work.environment(), **(settings or {})}
        cluster = None
        if server is not None:
            database_url = ends.enter_context(server.database())
        if database_url is not None:
            environment["WHIPPLE_DATABASE_URL"] = database_url
        if cluster_in is not None:
            cluster = ends.enter_context(cluster_in(folder / "cluster", 0))
            cluster.start_workers(WORKERS, **environment)
            environment |= cluster.settings()
        services = [Service(folder / "data", environment, name=f"service-{n}", **more) for n in range(count)]
        for service in services:
            ends.callback(service.kill)
            service.start()
            service.wait_until_listening()
        url = database_url or f"sqlite:///{services[0].data.absolute() / 'whipple.db'}"
        store = ends.enter_context(closing(Store.open(url, migrate=False)))
        yield CrashTest(work, services, tree, store, random.Random(seed), cluster, server)
