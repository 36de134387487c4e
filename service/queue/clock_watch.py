"""The watch over the wall clock: after a jump it pauses deletion by age, and it limits what goes by age in a day.

What it saw is in the store, so that a jump while no service ran is seen too. ``service.records.clock`` has the rules.
"""

import logging
from collections.abc import Callable
from contextlib import suppress
from datetime import UTC, datetime, timedelta

from service.records.clock import DAY, ClockHistory, ClockReading, read_clocks
from service.records.jobs import StoreUnavailable
from service.settings import Settings
from service.store import Store

log = logging.getLogger(__name__)

NOTE_SECONDS = 60.0  # between two notes of a clock that runs steadily


class ClockWatch:
    """Reads the clocks for the collector, and says and stores what it sees."""

    def __init__(self, settings: Settings, store: Store, read: Callable[[], ClockReading] = read_clocks):
        self._store = store
        self._read = read
        limits = (settings.retire_seconds, settings.forget_seconds, settings.retention_days * DAY)
        self._longest = max(limits)
        self._reading = read()
        self._history = ClockHistory(self._reading)

    def look(self) -> None:
        """Compare the clocks with what was seen before; called by the leader before it deletes by age."""
        reading = self._reading = self._read()
        stored = self._store.retention.clock_history()
        self._history = self._seen(stored, reading)
        is_due = stored is None or self._history.observed - stored.observed > NOTE_SECONDS
        if is_due or stored is None or (reading.boot, *_said(self._history)) != (stored.reading.boot, *_said(stored)):
            with suppress(StoreUnavailable):  # noted at a later look
                self._note(lambda history: self._seen(history, reading))
                self._say(None if stored is None else stored.paused)

    def moment_before(self, seconds: float) -> datetime:
        """The moment so many seconds before the last look."""
        return datetime.fromtimestamp(self._reading.wall, UTC) - timedelta(seconds=seconds)

    def is_paused(self, limit: float) -> bool:
        """Whether nothing is deleted for being older than ``limit`` seconds."""
        return self._history.why_paused(limit) is not None

    def may_go(self, kind: str, count: Callable[[], int], *, at_least: int) -> int:
        """How many of a kind may be deleted by age now; they are counted once more than ``at_least`` went in a day."""
        return self._history.may_go(kind, 0, at_least=at_least) or self._history.may_go(
            kind, count(), at_least=at_least
        )

    def note_gone(self, kind: str, number: int) -> None:
        """Note that so many of a kind are deleted by age."""
        self._note(lambda history: (history or self._history).with_gone(kind, number))

    def _note(self, change: Callable[[ClockHistory | None], ClockHistory]) -> None:
        self._history = self._store.retention.note_clock_history(change)

    def _seen(self, history: ClockHistory | None, reading: ClockReading) -> ClockHistory:
        """The history with a reading, and with the pause that follows from it."""
        return ClockHistory(reading) if history is None else history.seen(reading).with_pause(self._longest)

    def _say(self, before: str | None) -> None:
        """Log that a pause begins or ends."""
        paused = self._history.paused
        if paused is not None and paused != before:
            log.warning("nothing is deleted by age: %s", paused)
        elif paused is None and before is not None:
            log.info("the clock is believed again: deletion by age goes on")


def _said(history: ClockHistory) -> tuple[object, ...]:
    """What is noted at once when it changes."""
    return history.offset, history.jumped, history.stop, history.paused
