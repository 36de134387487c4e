"""The protocol of an engine, which the dispatcher calls."""

from collections.abc import Callable, Mapping
from typing import Protocol

from service.settings import Settings
from service.workers.attempt import Attempt, Inbox


class Engine(Protocol):
    """Computes attempts in slots, one at a time in each.

    It is opened with an inbox, where it puts ``ProgressMessage``, ``Ended`` (exactly one for each attempt that was
    submitted or followed, whatever happens), ``Away`` and ``Back``. The database row is the truth: an engine may lose
    anything at any moment, and retries nothing. Methods raise OSError while the scheduler they need is away.
    """

    def slots(self) -> int:
        """Attempts that can be under way at once; 0 while the engine is away."""

    def submit(self, attempt: Attempt) -> None:
        """Begin an attempt; ``Ended`` follows. More of them than slots wait for one another."""

    def stop(self, keys: list[str]) -> None:
        """Ask for the end of attempts, without a checkpoint; one that has not begun may miss it, so ask again."""

    def attempts(self) -> set[str]:
        """Keys of the attempts that the engine has, also of earlier lives of this service."""

    def follow(self, key: str) -> None:
        """Ask for the ending of an attempt of an earlier life: ``Ended``, as lost if the engine does not have it."""

    def forget(self, keys: list[str]) -> None:
        """Forget attempts whose rows tell how they ended."""

    def close(self, leave_seconds: float | None) -> None:
        """Let every attempt write a checkpoint and leave, within so many seconds, and stop the others.

        Every process that the engine started has ended then; raises TimeoutError for those that have not. With None
        attempts go on where they can outlive this process: another service, or the next life of this one, finds them.
        """


OpenEngine = Callable[[Inbox], Engine]


class RemoteEngine(Engine, Protocol):
    """An engine on other machines, for the addresses of a scheme; a class makes and asks for it."""

    @classmethod
    def opener(cls, settings: Settings) -> OpenEngine:
        """The function that opens the engine of the settings."""

    @classmethod
    def probe(cls, settings: Settings) -> Mapping[str, str]:
        """The reason why each worker receives no work, by address; empty if it receives work. Raises OSError."""
