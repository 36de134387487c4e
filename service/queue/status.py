"""What the interface asks of the dispatcher."""

from typing import Protocol


class DispatcherStatus(Protocol):
    """Whether the queue is worked through, by whom, and what keeps it from that."""

    def is_alive(self) -> bool:
        """Whether somebody here looks after the queue, or stands by to do so."""
        ...

    def leads(self) -> bool:
        """Whether it is this process that gives the work out."""
        ...

    def trouble(self) -> str | None:
        """Why nothing is begun although there is work; None: there is no reason."""
        ...

    def workers(self) -> int | None:
        """Runs that can be computed at once; None where another process leads."""
        ...
