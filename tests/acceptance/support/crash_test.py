"""The crash test: sweeps are submitted to a service, and its processes are killed while they are computed."""

import random
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from service.files.artifacts import Artifacts
from service.records.jobs import StoreUnavailable
from service.store import Store
from tests.acceptance.support.faults import AttemptObserver, Fault, KillMoment, ObservedAttempt, Victim
from tests.acceptance.support.process_tree import ProcessTree, kill_and_wait, parent_of, process_tree
from tests.acceptance.support.serving import Service
from tests.service.support.cluster import DaskCluster, ShellProcess, running
from tests.service.support.fakes import is_gone, wait_until

WORKERS = 2
MEMORY_LIMIT = "4GiB"  # of a run on a cluster
FASTEST = 5.0  # km/s more than the slowest
MOMENT_SECONDS = 120.0  # deadlines
END_SECONDS = 1800.0


@dataclass(frozen=True)
class Work:
    """Sweeps over speed and thickness; each shares all but one thickness with the one before."""

    speeds: int
    sweeps: int
    thicknesses: int = 2
    resolution: float = 4
    targets: str = "tests.acceptance.support.chained"
    run_seconds: float = 0.4  # of targets that only wait

    @property
    def runs(self) -> int:
        """The number of different runs."""
        return self.speeds * (self.sweeps + self.thicknesses - 1)

    def documents(self) -> list[dict[str, Any]]:
        return [self._document(number) for number in range(self.sweeps)]

    def environment(self) -> dict[str, str]:
        """Environment of a service that computes it."""
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


@dataclass
class CrashTest:
    """A service under test, and the faults that were injected."""

    work: Work
    folder: Path
    service: Service
    tree: ProcessTree
    store: Store
    chance: random.Random
    cluster: DaskCluster | None = None
    injected: list[Fault] = field(default_factory=list)
    # By job: processes of it that were killed.
    killed: Counter[str] = field(default_factory=Counter)

    def __post_init__(self) -> None:
        self.artifacts = Artifacts(self.service.data)
        self.attempts = AttemptObserver(self.store, self.artifacts)

    def submit(self) -> list[str]:
        """Submit every sweep, the first ones with higher priority; their ids."""
        documents = enumerate(self.work.documents())
        return [self.service.submit(document, priority=number) for number, document in documents]

    def inject(self, fault: Fault) -> None:
        """Wait for the moment of a fault, and kill its victim, unless the work ends before."""
        self._wait(lambda: self.store.last_event() >= fault.due)
        self._wait(lambda: self._is_injected(fault) or self._has_ended())

    def wait_for_the_end(self, ids: list[str]) -> None:
        """Wait until every sweep is published."""
        self._wait(lambda: self._all_ended(ids), seconds=END_SECONDS)

    def leave(self) -> set[int]:
        """Stop everything in order; the processes that are left."""
        self.service.wait_until_listening()
        assert self.service.leave() == 0, self.service.log_tail()
        if self.cluster is not None:
            self.cluster.end()
        return self.tree.left()

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
            states = dict(self.store.queue().states)
            raise AssertionError(f"{error}; {states}; {self.service.log_tail()}") from error

    def _restart_cluster(self) -> None:
        """Restart scheduler and workers, as systemd does; the service itself must be alive."""
        assert self.service.is_alive(), self.service.log_tail()
        if self.cluster is None:
            return
        if not _lives(self._scheduler()):
            self.cluster.start_scheduler()
        if not any(_lives(item) for item in self._of("workers")):
            self.cluster.start_workers(WORKERS, **self.work.environment())

    def _is_injected(self, fault: Fault) -> bool:
        """Whether an attempt was at the moment of the fault, and its victim was killed."""
        needs_process = fault.victim in (Victim.RUN, Victim.WORKER)
        target = self._choose(fault.moment, needs_process=needs_process)
        fell = target is not None and self._kill(fault.victim, target)
        if fell:
            self.injected.append(fault)
        return fell

    def _kill(self, victim: Victim, target: ObservedAttempt) -> bool:
        """Whether the victim lived until it was killed."""
        if victim is Victim.RUN:
            fell = target.pid is not None and kill_and_wait(target.pid)
            self.killed[target.claim.id] += fell
            return fell
        if victim is Victim.WORKER:
            worker = parent_of(target.pid or 0)
            return worker in self.tree.pids() and kill_and_wait(worker)
        if victim is Victim.SCHEDULER:
            self._scheduler().kill()
            return True
        self.service.kill()
        self.service.start()
        return True

    def _choose(self, moment: KillMoment, *, needs_process: bool) -> ObservedAttempt | None:
        """An attempt at this moment; a run that was hit before is spared: its third death is a failure."""
        attempts = self.attempts.at(moment)
        if needs_process:
            attempts = [item for item in attempts if item.pid and not self.killed[item.claim.id]]
        return self.chance.choice(attempts) if attempts else None

    def _has_ended(self) -> bool:
        return not any(count for state, count in self.store.queue().states.items() if not _is_end(state))

    def _all_ended(self, ids: list[str]) -> bool:
        return all(self.store.sweep(id).is_terminal for id in ids)

    def _of(self, name: str) -> list[ShellProcess]:
        assert self.cluster is not None
        return [item for item in self.cluster.processes if item.name.startswith(name)]

    def _scheduler(self) -> ShellProcess:
        return self._of("scheduler")[-1]


def _is_end(state: Any) -> bool:
    return str(state) in ("succeeded", "failed", "cancelled")


def _lives(process: ShellProcess) -> bool:
    return process.process.poll() is None and not is_gone(process.process.pid)


@contextmanager
def crash_test(
    work: Work,
    folder: Path,
    *,
    seed: int = 0,
    database_url: str | None = None,
    external: bool = False,
    settings: Mapping[str, str] | None = None,
    **more: Any,
) -> Iterator[CrashTest]:
    """A crash test on SQLite or another database, on this machine or with a cluster (``external``).

    ``settings`` are variables of the service (``WHIPPLE_...``), ``more`` fields of ``serving.Service``.
    """
    with ExitStack() as ends:
        tree = ends.enter_context(process_tree())
        environment = {**work.environment(), **(settings or {})}
        cluster = None
        if database_url is not None:
            environment["WHIPPLE_DATABASE_URL"] = database_url
        if external:
            cluster = ends.enter_context(running(folder / "cluster", 0))
            cluster.start_workers(WORKERS, **environment)
            environment |= _engine(cluster)
        service = Service(folder / "data", environment, **more)
        ends.callback(service.kill)
        service.start()
        service.wait_until_listening()
        url = database_url or f"sqlite:///{service.data.absolute() / 'whipple.db'}"
        store = ends.enter_context(closing(Store.open(url, migrate=False)))
        yield CrashTest(work, folder, service, tree, store, random.Random(seed), cluster)


def _engine(cluster: DaskCluster) -> Mapping[str, str]:
    remote = cluster.remote()
    return {
        "WHIPPLE_ENGINE": remote.address,
        "WHIPPLE_TLS_CA": str(remote.ca),
        "WHIPPLE_TLS_CERT": str(remote.certificate),
        "WHIPPLE_TLS_KEY": str(remote.key),
        "WHIPPLE_MEMORY_LIMIT": MEMORY_LIMIT,
    }
