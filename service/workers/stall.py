"""Whether an attempt has stalled: judged by its messages and by the time of its process on a processor."""

from dataclasses import dataclass

# An attempt has stalled after so many times its longest interval between two messages.
PATIENCE = 10.0

# Kernels are compiled and cubes are written without a message: a process that is busy for this share of the least limit
# has not stalled. A run that has begun its steps but takes none, however busy, has, after ``PATIENCE`` as long again.
BUSY_SHARE = 0.01

# A look at the attempt that comes later than this was frozen itself, with its machine or container (s).
LONGEST_LOOK = 1.0


@dataclass
class StallClock:
    """The time since an attempt was last heard, as far as it was watched."""

    least: float  # s, until it has stalled
    longest: float = 0.0  # interval between two messages, s
    quiet: float = 0.0  # since the last message, s
    idle: float = 0.0  # since the last message or work, s
    used: float = 0.0  # processor seconds when it was last seen at work

    def pass_by(self, seconds: float) -> None:
        """Let the time since the last look pass."""
        seconds = min(seconds, LONGEST_LOOK)
        self.quiet, self.idle = self.quiet + seconds, self.idle + seconds

    def hear(self) -> None:
        self.longest = max(self.longest, self.quiet)
        self.quiet = self.idle = 0.0

    def has_run_out(self, *, used: float, has_steps: bool) -> bool:
        """Whether the attempt has stalled; ``used``: the processor seconds of its process."""
        if used - self.used >= BUSY_SHARE * self.least:
            self.used, self.idle = used, 0.0
        limit = max(self.least, PATIENCE * self.longest)
        return self.idle > limit or (has_steps and self.quiet > PATIENCE * limit)
