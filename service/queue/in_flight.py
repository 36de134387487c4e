"""What this service has given to its engine, and what came back of it."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from service.records.attempt import Away, Back, Ended, Ending, Message, ProgressMessage
from service.records.jobs import Cause, Claim


class Attempts:
    """Attempts by their keys; forgotten only when their rows tell how they ended."""

    def __init__(self) -> None:
        self.given: set[str] = set()  # the engine has them from us
        self.held: dict[str, Claim] = {}  # the ones whose rows are ours in this reign
        self.ended: dict[str, Ending] = {}  # not yet registered
        self.told: dict[str, Mapping[str, Any]] = {}  # last progress, not yet written
        self.away: str | None = None  # why the engine cannot be asked
        self.is_back = False  # it can again, and nobody has looked yet

    def take(self, message: Message | None) -> bool:
        """Note what the engine said; whether it needs a turn soon."""
        if isinstance(message, ProgressMessage):
            self.told[message.key] = message.progress
            return False
        if isinstance(message, Ended):
            self.ended[message.key] = message.ending
        elif isinstance(message, Away):
            self.away = message.reason
        elif isinstance(message, Back):
            self.away, self.is_back = None, True
        return True

    def under_way(self) -> set[str]:
        """Attempts that the engine has not ended."""
        return self.given - self.ended.keys()

    def hold(self, claim: Claim) -> None:
        """Our row, and an attempt that the engine has, or is about to get."""
        self.given.add(claim.key)
        self.held[claim.key] = claim

    def find_lost(self, claim: Claim, ending: Ending) -> None:
        """Our row, and an attempt of an earlier life that nobody has any more."""
        self.held[claim.key] = claim
        self.ended[claim.key] = ending

    def forget(self, key: str) -> None:
        """The row has it."""
        self.given.discard(key)
        for known in (self.held, self.ended, self.told):
            known.pop(key, None)

    def excuse(self) -> None:
        """What ended badly while its disk was away is lost: that says nothing about the run."""
        for key, ending in self.ended.items():
            if ending.cause in (Cause.ERROR, Cause.CRASH):
                reason = f"the data directory was away: {ending.reason}"
                self.ended[key] = replace(ending, cause=Cause.LOST, reason=reason)

    def clear(self) -> None:
        """The engine is gone, with all it had."""
        for known in (self.given, self.held, self.ended, self.told):
            known.clear()
        self.away, self.is_back = None, False
