"""Bodies and heads that are made to cost much: they cost little, and nobody else waits for them."""

from collections.abc import Iterator

from service.api.middleware import BODY_SECONDS, HEAD_SECONDS
from tests.acceptance.checks import costly_requests
from tests.acceptance.checks.costly_requests import served
from tests.acceptance.support.costly_bodies import BODIES
from tests.claims import Row, claim

HEADER_BYTES = 200 << 20
HALF_SENT = (510, 900)  # more than may be connected, and fewer than a process may open


@claim(
    "bad-bodies",
    says="bodies of up to 4 MB that are made to cost much are refused within a second, and others answered meanwhile",
)
def bad_bodies() -> Iterator[Row]:
    with served() as service:
        yield from costly_requests.refused(service, BODIES)


@claim("heads", says="endless heads and half-sent heads by the hundred are closed, and others are answered meanwhile")
def endless_heads() -> Iterator[Row]:
    with served() as service:
        yield from costly_requests.closed(service, HEADER_BYTES, HALF_SENT, HEAD_SECONDS)
        yield from costly_requests.chunked(service)
        yield costly_requests.dribbled(service, BODY_SECONDS)
