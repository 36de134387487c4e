"""What the store asks of its database, and what it says when the database is locked or away."""

import threading
from contextlib import closing
from types import SimpleNamespace

import pytest
import sqlalchemy as sa

from service.records.jobs import StoreUnavailable
from service.store import Store, connection
from service.store.tables import SWEEPS
from tests.service.support.fakes import sweep_of, wait_until


def test_sqlite__is_durable_and_checks_its_references(sqlite_url: str) -> None:
    with closing(Store.open(sqlite_url)) as store, store._database.writing() as writing:
        pragmas = {
            name: writing.exec_driver_sql(f"PRAGMA {name}").scalar()
            for name in ("journal_mode", "synchronous", "foreign_keys", "busy_timeout")
        }
    assert pragmas == {
        "journal_mode": "wal",
        "synchronous": 2,  # FULL
        "foreign_keys": 1,
        "busy_timeout": connection.BUSY_MILLISECONDS,
    }


def test_postgresql__is_durable_and_waits_for_nothing_for_ever(postgresql_url: str) -> None:
    with closing(Store.open(postgresql_url)) as store, store._database.writing() as writing:
        settings = {
            name: writing.exec_driver_sql(f"SHOW {name}").scalar()
            for name in (
                "synchronous_commit",
                "lock_timeout",
                "idle_in_transaction_session_timeout",
            )
        }
    assert settings == {
        "synchronous_commit": "on",
        "lock_timeout": "20s",
        "idle_in_transaction_session_timeout": "8s",
    }


def test_readers__see_one_moment(database_url: str) -> None:
    with (
        closing(Store.open(database_url, cost=lambda run: 1.0)) as store,
        closing(Store.open(database_url, cost=lambda run: 1.0)) as other,
    ):
        count = sa.select(sa.func.count()).select_from(SWEEPS)
        with store._database.reading() as reading:
            before = reading.execute(count).scalar()
            other.create_sweep(sweep_of(1))
            assert reading.execute(count).scalar() == before


def test_locked__is_said_and_nothing_changes(
    database_url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "BUSY_MILLISECONDS", 50)
    with (
        closing(Store.open(database_url, cost=lambda run: 1.0)) as store,
        closing(Store.open(database_url, cost=lambda run: 1.0)) as other,
    ):
        with other._database.writing() as holding:
            holding.execute(sa.select(SWEEPS.c.id))
            with pytest.raises(StoreUnavailable, match="lock"):
                store.create_sweep(sweep_of(1))
            with pytest.raises(StoreUnavailable, match="lock"):
                store.ping()
            assert store.sweeps().items == ()  # reading goes on
        assert store.create_sweep(sweep_of(1)).planned == 1


def test_locked__by_another_thread_of_the_same_service_too(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "BUSY_MILLISECONDS", 50)
    held, done = threading.Event(), threading.Event()

    def hold() -> None:
        with store._database.writing():
            held.set()
            done.wait(60.0)

    thread = threading.Thread(target=hold)
    thread.start()
    try:
        wait_until(held.is_set)
        with pytest.raises(StoreUnavailable, match="locked"):
            store.ping()
    finally:
        done.set()
        thread.join()
    store.ping()


def test_writer__that_waited_for_its_own_process_waits_less_for_others(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    database, now = store._database, [0.0]

    def acquire(timeout: float) -> bool:
        """As when another thread of this process holds it for half a second."""
        assert timeout > 0.5
        now[0] += 0.5
        return True

    mutex = SimpleNamespace(acquire=acquire, release=lambda: None)
    monkeypatch.setattr(database, "_mutex", mutex)
    monkeypatch.setattr(connection, "time", SimpleNamespace(monotonic=lambda: now[0]))
    with database.writing() as writing:
        if database.is_sqlite:
            left = int(writing.exec_driver_sql("PRAGMA busy_timeout").scalar_one())
        else:
            query = "SELECT setting FROM pg_settings WHERE name = 'lock_timeout'"
            left = int(writing.exec_driver_sql(query).scalar_one())
    assert left == connection.BUSY_MILLISECONDS - 500


def test_server__that_ends_the_connections_is_used_again(postgresql_url: str) -> None:
    with closing(Store.open(postgresql_url, cost=lambda run: 1.0)) as store:
        store.create_sweep(sweep_of(1))
        end = (
            "SELECT pg_terminate_backend(pid) FROM pg_stat_activity "
            "WHERE datname = current_database() AND pid <> pg_backend_pid()"
        )
        with closing(Store.open(postgresql_url)) as other, other._database.writing() as writing:
            writing.execute(sa.text(end))
        assert len(store.sweeps().items) == 1


def test_server__that_is_away_is_said(postgresql_url: str) -> None:
    away = sa.make_url(postgresql_url).set(database="nowhere")
    with pytest.raises(StoreUnavailable, match="nowhere"):
        Store.open(away.render_as_string(hide_password=False))


def test_file__that_cannot_be_written_is_said(tmp_path: object) -> None:
    with pytest.raises(StoreUnavailable):
        Store.open(f"sqlite:///{tmp_path}/no/such/folder/whipple.db")


def test_orders__the_dispatcher_hears_of_them(store: Store) -> None:
    heard: list[None] = []
    store.on_order(lambda: heard.append(None))
    row = store.create_sweep(sweep_of(1))
    store.cancel_sweep(row.id)
    assert len(heard) == 2
