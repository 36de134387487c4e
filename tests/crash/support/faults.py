"""The faults of a crash test: which process is killed, and at which moment."""

from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from service.files.artifacts import Artifacts
from service.records.jobs import Kind, Lease, State
from service.store import Store
from tests.service.support.fakes import is_gone


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
