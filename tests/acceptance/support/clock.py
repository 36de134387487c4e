"""``whipple serve`` with a clock that can be set: seconds in a file are added to what time it is.

``python -m tests.acceptance.support.clock FILE serve ...``; everything in the process sees it.
"""

import sys
import time
from datetime import datetime, tzinfo
from pathlib import Path
from typing import Self


class SettableClock(datetime):
    """The time of day, as somebody has set it."""

    @classmethod
    def now(cls, tz: tzinfo | None = None) -> Self:
        return cls.fromtimestamp(time.time(), tz)


def main() -> None:
    """Set the clock, then start the command."""
    file, right = Path(sys.argv.pop(1)), time.time
    time.time = lambda: right() + float(file.read_text())
    from service.cli import main as cli
    from service.store import statements

    statements.datetime = SettableClock  # type: ignore[misc]
    cli.main()


if __name__ == "__main__":
    main()
