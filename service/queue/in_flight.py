"""Attempts in flight: given to the engine, and ended without their row knowing it yet."""

from dataclasses import replace

from service.queue.retry import CRASHES
from service.records.jobs import AttemptProgress, Cause, Lease
from service.workers.attempt import Away, Back, Ended, Ending, Message, ProgressMessage


class AttemptsInFlight:
    """Attempts by their keys; forgotten only when their rows tell how they ended."""

    def __init__(self) -> None:
        self.submitted: set[str] = set()  # by us to the engine
        self.leases: dict[str, Lease] = {}  # leases of this term, by key
        self.ended: dict[str, Ending] = {}  # not yet registered
        self.progress: dict[str, AttemptProgress] = {}  # the last, not yet written
        self.away: str | None = None  # why the engine cannot be asked
        self.is_back = False  # the engine can be asked again, and nobody has yet

    def receive(self, message: Message | None) -> bool:
        """Note a message of the engine; whether it needs a tick soon."""
        match message:
            case ProgressMessage(key, progress):
                self.progress[key] = progress
                return False
            case Ended(key, ending):
                self.ended[key] = ending
            case Away(reason):
                self.away = reason
            case Back():
                self.away, self.is_back = None, True
        return True

    def under_way(self) -> set[str]:
        """Attempts that the engine has not ended."""
        return self.submitted - self.ended.keys()

    def add(self, lease: Lease) -> None:
        """Add an attempt of ours that the engine has, or is about to get."""
        self.submitted.add(lease.key)
        self.leases[lease.key] = lease

    def add_lost(self, lease: Lease, reason: str) -> None:
        """Add an attempt of an earlier process that the engine does not have."""
        self.leases[lease.key] = lease
        self.ended[lease.key] = Ending.lost("Lost", reason)

    def forget(self, key: str) -> None:
        """Forget an attempt whose row tells how it ended."""
        self.submitted.discard(key)
        for by_key in (self.leases, self.ended, self.progress):
            by_key.pop(key, None)

    def excuse_failures(self) -> None:
        """Count attempts that failed while the data directory was missing as lost, not as failures."""
        for key, ending in self.ended.items():
            if ending.cause in (Cause.ERROR, *CRASHES):
                reason = f"the data directory was missing: {ending.reason}"
                self.ended[key] = replace(ending, cause=Cause.LOST, reason=reason)

    def clear(self) -> None:
        """Forget all attempts: the engine is closed."""
        for keys in (self.submitted, self.leases, self.ended, self.progress):
            keys.clear()
        self.away, self.is_back = None, False
