"""``whipple serve`` that waits for less time: for a lock of the database, a request, and after a full disk.

``python -m tests.acceptance.support.short_timeouts serve ...``
"""

from service.api import middleware
from service.cli import main as cli
from service.files import disk_space as space
from service.store import connection

BUSY_MILLISECONDS = 2000
PAUSE_SECONDS = 5.0
HEAD_SECONDS = 2.0
BODY_SECONDS = 2.0


def main() -> None:
    """Shorten the times, then start the command."""
    connection.BUSY_MILLISECONDS = BUSY_MILLISECONDS
    space.PAUSE_SECONDS = PAUSE_SECONDS
    middleware.HEAD_SECONDS = HEAD_SECONDS
    middleware.BODY_SECONDS = BODY_SECONDS
    cli.main()


if __name__ == "__main__":
    main()
