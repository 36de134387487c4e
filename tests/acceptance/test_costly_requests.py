"""Bodies and heads that are made to cost much, sent to a real service."""

from collections.abc import Iterator

import pytest

from tests.acceptance.checks import costly_requests
from tests.acceptance.support import short_timeouts
from tests.acceptance.support.serving import Service
from tests.rows import check

COSTLY = (
    "JSON: 3 000 materials",
    "JSON: a key twice, at the end",
    "JSON: empty lists",
    "JSON: key of 4 MB",
    "JSON: unit of letters",
    "JSON: column of blanks",
    "JSON: cell of digits",
    "YAML: 200 kB of keys",
    "YAML: numbers in brackets",
    "YAML: sexagesimal number",
    "YAML: tag without value",
)
HEADER, HALVES = 20 << 20, (510,)


@pytest.fixture(scope="module")
def service() -> Iterator[Service]:
    with costly_requests.served(("-m", "tests.acceptance.support.short_timeouts")) as served:
        yield served


def test_bad_body__is_refused_cheaply(service: Service) -> None:
    check(costly_requests.refused(service, COSTLY, costly_requests.BUSY))


def test_head__that_never_ends_is_closed_and_others_are_served(service: Service) -> None:
    check(
        costly_requests.closed(
            service, HEADER, HALVES, short_timeouts.HEAD_SECONDS, costly_requests.BUSY
        )
    )


def test_body__in_chunks_of_one_byte_holds_nobody_up(service: Service) -> None:
    check(costly_requests.chunked(service, costly_requests.BUSY))


def test_body__that_comes_byte_by_byte_is_closed(service: Service) -> None:
    check([costly_requests.dribbled(service, short_timeouts.BODY_SECONDS)])
