"""The wall clock as a witness of ages: compared with a clock that nobody can set, and not believed after a jump.

A thing is deleted by age once it is older than a limit. The clock that stamped it may have been behind, and the one
that says "now" may be ahead; either way it looks older than it is. What is known is how long the machine has run,
asleep or awake, and by how much the wall clock moved beside that (``ClockHistory.offset``). While that is not zero, or
once it was below, nothing goes by age. That ends when a clock that was ahead is back, or once the machine has run as
long as the limit: by then whatever was stamped before the jump is really that old.

Of a machine that was switched off, or of another one that takes over, only the moment that was seen last is known. An
earlier moment is a jump back. A later one is a stop, however long; after a long one the clock is believed once the
machine has run for ``SETTLING``, in which time servers can correct it.
"""

import time
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple, Self

HOUR, DAY = 3600.0, 24 * 3600.0
TOLERANCE = 300.0  # s: time servers make smaller steps, and ages are hours and more
LONG_STOP = DAY  # s; a shorter stop hides no jump that matters
SETTLING = DAY  # s of running after a long stop
SHARE = 10  # of what is stored one part in so many goes by age in a day
BOOT_ID = Path("/proc/sys/kernel/random/boot_id")
TRUST = "`whipple doctor --trust-clock`"


class ClockReading(NamedTuple):
    """Two clocks at one moment."""

    wall: float  # seconds since the epoch
    running: float  # seconds since the machine was switched on, asleep or awake; nobody sets it
    boot: str  # identity of that switching on


@dataclass(frozen=True)
class ClockHistory:
    """The jumps of the wall clock that were seen, and what was deleted by age lately."""

    reading: ClockReading  # the last one; small steps are left out of it until they add up to a jump
    observed: float = 0.0  # seconds that were seen to pass, over all boots
    offset: float = 0.0  # seconds that the wall clock is ahead of where it would be without jumps
    jumped: float | None = None  # ``observed`` at the last jump
    behind: float | None = None  # ``observed`` at the last jump forward of a clock that was behind
    stop: float | None = None  # ``observed`` at the last long stop
    paused: str | None = None  # why nothing is deleted by age
    gone: Mapping[str, Mapping[str, int]] = field(default_factory=dict)  # by kind and hour of ``observed``

    @classmethod
    def from_json(cls, plain: Mapping[str, Any]) -> Self:
        """The history that ``as_json`` wrote."""
        return cls(**{**plain, "reading": ClockReading(*plain["reading"])})

    def as_json(self) -> dict[str, Any]:
        """The history as plain objects."""
        return asdict(self)

    def seen(self, reading: ClockReading) -> Self:
        """The history once the clocks were read again."""
        passed = reading.wall - self.reading.wall
        if reading.boot == self.reading.boot:
            ran = reading.running - self.reading.running
            now = replace(self, observed=self.observed + ran)
            if abs(jump := passed - ran) > TOLERANCE:
                return replace(now._jumped(jump), reading=reading)
            return replace(now, reading=reading._replace(wall=reading.wall - jump))
        now = replace(self, reading=reading, stop=self.observed if passed > LONG_STOP else self.stop)
        # A clock that was set back may have been set right meanwhile.
        jump = min(passed, max(0.0, -self.offset))
        return now._jumped(jump) if abs(jump) > TOLERANCE else now

    def trusted(self) -> Self:
        """The history of a clock that a person says is right."""
        return replace(self, offset=0.0, jumped=None, behind=None, stop=None, paused=None)

    def with_pause(self, limit: float) -> Self:
        """The history with the reason of ``why_paused``."""
        return replace(self, paused=self.why_paused(limit))

    def why_paused(self, limit: float) -> str | None:
        """The reason why nothing is deleted for being older than ``limit`` seconds; None: it is deleted."""
        if abs(self.offset) > TOLERANCE and self._is_lately(self.jumped, limit):
            jump = f"jumped {'forward' if self.offset > 0 else 'back'} by {_span(abs(self.offset))}"
            return (
                f"the clock has {jump}; deletion by age goes on once it is back, after {_span(limit)} of running, or "
                f"at {TRUST}"
            )
        if self._is_lately(self.behind, limit):
            what = "the clock was behind, and what was stored meanwhile looks older than it is"
            return f"{what}; deletion by age goes on after {_span(limit)} of running, or at {TRUST}"
        if self._is_lately(self.stop, SETTLING):
            return (
                f"nothing ran for more than {_span(LONG_STOP)}, or the clock is wrong; deletion by age goes on after "
                f"{_span(SETTLING)} of running, or at {TRUST}"
            )
        return None

    def may_go(self, kind: str, stored: int, *, at_least: int) -> int:
        """How many of a kind may be deleted by age now: in a day a tenth of those stored, or ``at_least`` so many."""
        gone = sum(self._lately(kind).values())
        return max(0, max(at_least, (stored + gone) // SHARE) - gone)

    def with_gone(self, kind: str, count: int) -> Self:
        """The history once so many of a kind were deleted by age."""
        hour, lately = str(int(self.observed // HOUR)), self._lately(kind)
        return replace(self, gone={**self.gone, kind: {**lately, hour: lately.get(hour, 0) + count}})

    def _lately(self, kind: str) -> dict[str, int]:
        """The numbers of a kind that went in the last day, by hour."""
        first = int((self.observed - DAY) // HOUR)
        return {hour: count for hour, count in self.gone.get(kind, {}).items() if int(hour) >= first}

    def _is_lately(self, moment: float | None, limit: float) -> bool:
        """Whether a moment of ``observed`` is less than ``limit`` seconds of running ago."""
        return moment is not None and self.observed - moment < limit

    def _jumped(self, seconds: float) -> Self:
        """The history after a jump."""
        behind = self.observed if seconds > 0.0 > self.offset + TOLERANCE else self.behind
        return replace(self, offset=self.offset + seconds, jumped=self.observed, behind=behind)


def read_clocks() -> ClockReading:
    """Both clocks, now."""
    return ClockReading(time.time(), time.clock_gettime(time.CLOCK_BOOTTIME), BOOT_ID.read_text().strip())


def _span(seconds: float) -> str:
    """A time span of hours or days.

    >>> _span(45 * DAY), _span(5400.0)
    ('45 days', '1.5 hours')
    """
    return f"{seconds / DAY:.3g} days" if seconds >= 2 * DAY else f"{seconds / HOUR:.3g} hours"
