"""One service leads: by a lock of the server that ends with its connection; no clock is asked."""

import time
from collections.abc import Iterator
from contextlib import ExitStack, closing

import pytest
import sqlalchemy as sa

from service.records.jobs import StoreUnavailable
from service.store import Store, connection
from tests.service.support.fakes import wait_until


@pytest.fixture
def replicas(postgresql_url: str) -> Iterator[tuple[Store, Store]]:
    """Two services on one PostgreSQL."""
    with ExitStack() as ends:
        one, two = (ends.enter_context(closing(Store.open(postgresql_url))) for _ in range(2))
        yield one, two


def test_lead__one_replica_alone(replicas: tuple[Store, Store]) -> None:
    one, two = replicas
    leading = one.lead("one:1")
    assert leading is not None
    assert leading.holds()
    assert two.lead("two:2") is None
    assert two.queue().leader == "one:1"
    leading.close()


def test_lead__another_takes_over_when_it_is_given_back(replicas: tuple[Store, Store]) -> None:
    one, two = replicas
    leading = one.lead("one:1")
    assert leading is not None
    leading.close()
    assert not leading.holds()
    following = wait_until(lambda: two.lead("two:2"))
    assert following.holds()
    assert one.queue().leader == "two:2"
    following.close()


def test_lead__ends_with_its_connection_and_does_not_come_back(
    replicas: tuple[Store, Store],
) -> None:
    one, two = replicas
    leading = one.lead("one:1")
    assert leading is not None
    with two._database.writing() as connection:
        ended = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE application_name = 'one:1'"
        connection.execute(sa.text(ended))
    following = wait_until(lambda: two.lead("two:2"))
    assert not leading.holds()
    assert not leading.holds()
    following.close()
    assert not leading.holds()
    leading.close()


def test_lead__of_a_silent_service_ends(
    replicas: tuple[Store, Store], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("service.store.leadership.IDLE_SECONDS", 0.5)
    monkeypatch.setattr("service.store.leadership.PING_SECONDS", 60.0)  # as if it were frozen
    one, two = replicas
    leading = one.lead("one:1")
    assert leading is not None
    following = wait_until(lambda: two.lead("two:2"), seconds=5)
    assert not leading.holds()
    leading.close()
    following.close()


def test_lead__of_a_service_whose_turn_takes_long_goes_on(
    replicas: tuple[Store, Store], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("service.store.leadership.IDLE_SECONDS", 0.5)
    monkeypatch.setattr("service.store.leadership.PING_SECONDS", 0.1)
    one, two = replicas
    leading = one.lead("one:1")
    assert leading is not None
    end = time.monotonic() + 1.5  # nobody asks whether it holds
    wait_until(lambda: time.monotonic() > end)
    assert two.lead("two:2") is None
    assert leading.holds()
    leading.close()


def test_transaction__of_a_frozen_service_ends(
    replicas: tuple[Store, Store], monkeypatch: pytest.MonkeyPatch
) -> None:
    timeout = {"idle_in_transaction_session_timeout": "500ms"}
    monkeypatch.setattr(connection, "POSTGRESQL", connection.POSTGRESQL | timeout)
    url = replicas[0]._database.url.render_as_string(hide_password=False)
    with closing(Store.open(url)) as frozen:
        writing = frozen._database.writing()
        writing.__enter__()
        assert replicas[1].begin_epoch("two:2") == 1
        with pytest.raises(StoreUnavailable):
            writing.__exit__(None, None, None)


def test_lead__nobody_does_at_first(replicas: tuple[Store, Store]) -> None:
    assert replicas[0].queue().leader is None


def test_lead__of_another_database_does_not_count(
    replicas: tuple[Store, Store], postgresql_url: str
) -> None:
    leading = replicas[0].lead("one:1")
    assert leading is not None
    url = sa.make_url(postgresql_url).set(database="empty_store")
    with closing(Store.open(url.render_as_string(hide_password=False))) as elsewhere:
        assert elsewhere.queue().leader is None
        other = elsewhere.lead("other:1")
        assert other is not None
        other.close()
    leading.close()


def test_lead__a_server_that_is_away_is_said(postgresql_url: str) -> None:
    with closing(Store.open(postgresql_url)) as store:
        store._database.url = sa.make_url(postgresql_url).set(database="nowhere")
        with pytest.raises(StoreUnavailable):
            store.lead("one:1")


def test_lead__on_sqlite_whoever_holds_the_directory(sqlite_url: str) -> None:
    with closing(Store.open(sqlite_url)) as store:
        leading = store.lead("one:1")
        assert leading is not None
        assert store.queue().leader is None
        store.begin_epoch("one:1")
        assert store.queue().leader == "one:1"
        leading.close()
        assert leading.holds()
