"""Leadership: a lock of the server that ends with its connection."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, closing

import pytest
import sqlalchemy as sa

from service.store import Store
from tests.service.support.fakes import wait_until

Replicas = tuple[Store, Store]


@pytest.fixture
def replicas(postgresql_url: str) -> Iterator[Replicas]:
    with ExitStack() as ends:
        one, two = (ends.enter_context(closing(Store.open(postgresql_url))) for _ in range(2))
        yield one, two


def test_lead__is_the_right_of_one_replica_until_it_gives_it_back(replicas: Replicas) -> None:
    one, two = replicas
    assert one.queue.status().leader is None
    leading = one.terms.lead("one:1")
    assert leading is not None
    assert leading.holds()
    assert two.terms.lead("two:2") is None
    assert two.queue.status().leader == "one:1"
    leading.close()
    assert not leading.holds()
    following = wait_until(lambda: two.terms.lead("two:2"))
    assert one.queue.status().leader == "two:2"
    following.close()


def test_lead__ends_with_its_connection_for_good(replicas: Replicas) -> None:
    one, two = replicas
    leading = one.terms.lead("one:1")
    assert leading is not None
    with two.database.writing() as writing:
        end = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name = 'one:1'"
        writing.execute(sa.text(end))
    following = wait_until(lambda: two.terms.lead("two:2"))
    assert not leading.holds()
    following.close()
    assert not leading.holds()
    leading.close()


@pytest.mark.parametrize(("ping", "is_replaced"), [(60.0, True), (0.1, False)])
def test_lead__of_a_silent_service_ends(
    replicas: Replicas, monkeypatch: pytest.MonkeyPatch, ping: float, is_replaced: bool
) -> None:
    """A frozen process sends no pings; one in a long tick does."""
    monkeypatch.setattr("service.store.leadership.IDLE_SECONDS", 1.5)
    monkeypatch.setattr("service.store.leadership.PING_SECONDS", ping)
    one, two = replicas
    leading = one.terms.lead("one:1")
    assert leading is not None
    if is_replaced:
        following = wait_until(lambda: two.terms.lead("two:2"), seconds=15)
        assert not leading.holds()
        following.close()
    else:
        end = time.monotonic() + 3.0
        wait_until(lambda: time.monotonic() > end)
        assert two.terms.lead("two:2") is None
        assert leading.holds()
    leading.close()


def test_lead__is_of_one_database(replicas: Replicas, postgresql_url: str) -> None:
    leading = replicas[0].terms.lead("one:1")
    assert leading is not None
    url = sa.make_url(postgresql_url).set(database="empty_store")
    with closing(Store.open(url.render_as_string(hide_password=False))) as elsewhere:
        assert elsewhere.queue.status().leader is None
        other = elsewhere.terms.lead("other:1")
        assert other is not None
        other.close()
    leading.close()


def test_lead__on_sqlite_follows_the_lock_of_the_directory(sqlite_url: str) -> None:
    with closing(Store.open(sqlite_url)) as store:
        leading = store.terms.lead("one:1")
        assert leading is not None
        store.terms.begin("one:1")
        assert store.queue.status().leader == "one:1"
        leading.close()
        assert leading.holds()
