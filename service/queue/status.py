"""The state of a dispatcher, as the API reports it."""

from typing import Protocol


class DispatcherStatus(Protocol):
    """Whether the queue is worked through, by which process, and what blocks it."""

    def is_alive(self) -> bool:
        """Whether this process works through the queue, or stands by to do so."""
        ...

    def leads(self) -> bool:
        """Whether this process is the leader, and its last tick could use the database."""
        ...

    def is_refused(self) -> bool:
        """Whether the database refused the last tick."""
        ...

    def blocked_reason(self) -> str | None:
        """The reason why no job starts; None: the queue is not blocked."""
        ...

    def workers(self) -> int | None:
        """Attempts that can be under way at once; None where another process leads."""
        ...
