"""Bodies and heads that are made to cost much, sent to a real service."""

from collections.abc import Callable, Iterator
from contextlib import closing

import pytest

from service.records.jobs import Scope
from service.records.settings import Settings
from service.store import Store
from tests.acceptance.checks import costly_requests
from tests.acceptance.support import short_timeouts
from tests.acceptance.support.serving import Service
from tests.rows import Row, check
from tests.service.support.api import LARGE_SWEEPS

COSTLY = (
    "JSON: 3 000 materials",
    "JSON: a key twice, at the end",
    "JSON: empty lists",
    "JSON: key of 4 MB",
    "JSON: refused points",
    "JSON: unit of letters",
    "JSON: unknown axes",
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
    check(costly_requests.closed(service, HEADER, HALVES, short_timeouts.HEAD_SECONDS, costly_requests.BUSY))


def test_body__in_chunks_of_one_byte_holds_nobody_up(service: Service) -> None:
    check(costly_requests.chunked(service, costly_requests.BUSY))


def test_body__that_comes_byte_by_byte_is_closed(service: Service) -> None:
    check([costly_requests.dribbled(service, short_timeouts.BODY_SECONDS)])


@pytest.mark.claim("mend-again", "large-sweeps", minutes=4.0)
def test_large_sweeps__at_once_leave_the_service_alive_ready_and_small(compared: Callable[[Row], None]) -> None:
    """64 estimates and 16 submissions of large sweeps at once hold nobody up, and are answered or refused."""
    scopes = {"read": Scope.READ, "submit": Scope.SUBMIT, "other": Scope.READ}
    with costly_requests.served() as served:
        with closing(Store.open(Settings(data=served.data).url, migrate=False)) as store:
            secrets = {name: store.create_key(name, [scope])[1] for name, scope in scopes.items()}
        flood = costly_requests.Flood(estimates=64, submissions=16, seconds=60.0)
        for row in costly_requests.flooded(served, secrets, [*LARGE_SWEEPS.values()], flood):
            compared(row)


@pytest.mark.claim("mend-again", "pipelining", minutes=0.5)
def test_pipelining__by_hundreds_without_a_key_holds_nobody_up(compared: Callable[[Row], None]) -> None:
    """600 connections that send requests for the documentation and read nothing hold nobody up."""
    with costly_requests.served() as served:
        for row in costly_requests.pipelined(served, 600, 15.0):
            compared(row)
