"""The faults of a crash test: which process is killed, and at which moment."""

import random
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from service.files.artifacts import Artifacts
from service.records.jobs import Kind, Lease, State
from service.store import Store
from studies.quantities.files import RESULT
from tests.service.support.fakes import is_gone

# Begin and end of the kills, in events for each run: a run has two at least.
FIRST, LAST = 0.05, 1.3


class Victim(StrEnum):
    RUN = "run"  # the warm process that computes it, or publishes
    WORKER = "worker"  # of a cluster
    SCHEDULER = "scheduler"  # the same
    SERVICE = "service"
    DATABASE = "database"  # the server, PostgreSQL


class KillMoment(StrEnum):
    ANY = "at random"
    CLAIMED = "claimed"  # a row says running, and no process has begun
    COMPUTING = "computing"
    CHECKPOINTED = "checkpointed"
    WRITTEN = "written"  # an answer is complete, and no row names it
    PUBLISHING = "publishing"


# With a process of its own.
OF_A_PROCESS = (KillMoment.CHECKPOINTED, KillMoment.COMPUTING, KillMoment.PUBLISHING, KillMoment.ANY)


@dataclass(frozen=True)
class Fault:
    """One kill -9."""

    due: int  # number of the event in the store, not before it
    victim: Victim
    moment: KillMoment


def draw_faults(seed: int, victims: Mapping[Victim, int], runs: int) -> list[Fault]:
    """Kills in a random order at random events, at every kind of moment."""
    chance = random.Random(seed)
    chosen = [victim for victim, count in victims.items() for _ in range(count)]
    chance.shuffle(chosen)
    dues = sorted(int(chance.uniform(FIRST, LAST) * runs) for _ in chosen)
    met: Counter[Victim] = Counter()
    drawn = []
    for due, victim in zip(dues, chosen, strict=True):
        moments = OF_A_PROCESS if victim in (Victim.RUN, Victim.WORKER) else tuple(KillMoment)
        drawn.append(Fault(due, victim, moments[met[victim] % len(moments)]))
        met[victim] += 1
    return drawn


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
        if claim.state is State.RUNNING and claim.kind is Kind.PUBLISH:
            moments.add(KillMoment.PUBLISHING)
        elif claim.state is State.RUNNING:
            has_answer = (folder / RESULT).is_file()
            moments |= {KillMoment.WRITTEN} if has_answer else set()
            moments |= {KillMoment.CLAIMED} if pid is None else {KillMoment.COMPUTING}
            if pid is not None and self._artifacts.checkpoint(claim.id).is_file():
                moments.add(KillMoment.CHECKPOINTED)
        return ObservedAttempt(claim, pid, frozenset(moments))


def _pid(file: Path) -> int | None:
    """The process that a file names, while it lives."""
    try:
        pid = int(file.read_text())
    except (OSError, ValueError):
        return None
    return None if is_gone(pid) else pid
