"""A data directory that is renamed away, and a leader that is frozen."""

from collections.abc import Iterator

from tests.acceptance.checks import shared_disk
from tests.acceptance.checks.common import folder
from tests.claims import Row, claim
from tests.service.support.databases import postgresql_server


@claim(
    "disk-identity",
    says="the data directory renamed away and back, while a service on PostgreSQL runs and before it starts: no "
    "result is forgotten, none is computed again",
)
def disk_identity() -> Iterator[Row]:
    with folder() as place, postgresql_server() as server, server.database() as url:
        yield from shared_disk.directory_moved(place, url)


@claim("frozen-leader", says="a leader that is frozen (SIGSTOP) is replaced within 15 s, and stands by when it goes on")
def frozen_leader() -> Iterator[Row]:
    with folder() as place, postgresql_server() as server, server.database() as url:
        yield from shared_disk.frozen_leader(place, url)
