"""Databases: durability, waits that end, tables that are made, migrated or refused."""

import shutil
import threading
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
import sqlalchemy as sa

from service import migrations
from service.records.jobs import Cause, StoreUnavailable, Submission
from service.store import Store, connection
from service.store.connection import Database
from service.store.tables import REVISION, SWEEPS
from tests.service.support.databases import Postgresql
from tests.service.support.fakes import runs_of, sweep_of, wait_until
from tests.service.support.rows import finish_all

NEXT = """
import sqlalchemy as sa
from alembic import op

revision, down_revision = "next", "REVISION"


def upgrade():
    op.add_column("sweeps", sa.Column("note", sa.Text, nullable=False, server_default="none"))
    {more}
"""
SETTINGS: dict[str, dict[str, str | int]] = {
    "sqlite": {
        "PRAGMA journal_mode": "wal",
        "PRAGMA synchronous": 2,  # FULL
        "PRAGMA foreign_keys": 1,
        "PRAGMA busy_timeout": connection.BUSY_MILLISECONDS,
    },
    "postgresql": {
        "SHOW synchronous_commit": "on",
        "SHOW lock_timeout": "20s",
        "SHOW idle_in_transaction_session_timeout": "8s",
    },
}


def test_connection__is_durable_and_waits_for_no_lock_for_ever(store: Store) -> None:
    database = store.database
    settings = SETTINGS["sqlite" if database.is_sqlite else "postgresql"]
    with database.writing() as writing:
        values = {query: writing.exec_driver_sql(query).scalar() for query in settings}
    assert values == settings


def test_writer__that_waits_too_long_for_another_thread_is_refused(
    store: Store, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(connection, "BUSY_MILLISECONDS", 50)
    held, done = threading.Event(), threading.Event()

    def hold() -> None:
        with store.database.writing():
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


def test_database__that_cannot_be_used_is_unavailable(postgresql_url: str, tmp_path: Path) -> None:
    away = sa.make_url(postgresql_url).set(database="nowhere")
    with pytest.raises(StoreUnavailable, match="nowhere"):
        Store.open(away.render_as_string(hide_password=False))
    with pytest.raises(StoreUnavailable):
        Store.open(f"sqlite:///{tmp_path}/no/such/folder/whipple.db")


@pytest.fixture
def own_url(request: pytest.FixtureRequest, store: Store, database_url: str) -> Iterator[str]:
    """A database whose tables a test may change."""
    if store.database.is_sqlite:
        yield database_url
        return
    server: Postgresql = request.getfixturevalue("postgresql")
    with server.database() as url:
        yield url


def with_next_revision(folder: Path, more: str = "") -> str:
    """Location of the migrations with one more."""
    copied = shutil.copytree(Path(migrations.__file__).parent, folder / "migrations")
    (copied / "versions" / "next.py").write_text(NEXT.format(more=more).replace("REVISION", REVISION))
    return str(copied)


def test_migration__keeps_what_was_accepted(own_url: str, tmp_path: Path) -> None:
    with closing(Store.open(own_url)) as store:
        done = store.sweeps.create(Submission(sweep_of(runs_of("fine")))).id
        finish_all(store)
        waiting = store.sweeps.create(Submission(sweep_of(runs_of("fine", first=10)))).id
        [held] = store.leases.take(1, store.terms.begin("before"))
        before = [store.sweeps.get(id) for id in (done, waiting)]
        with closing(Database(own_url, with_next_revision(tmp_path), "next")) as database:
            database.migrate()
            assert database.revision() == "next"
            with database.reading() as reading:
                notes: set[str] = set(reading.scalars(sa.select(sa.column("note")).select_from(SWEEPS)))
                assert notes == {"none"}
        assert [store.sweeps.get(id) for id in (done, waiting)] == before
        store.leases.requeue(held, Cause.LOST, reason="the service ended during the attempt")
        finish_all(store)
        assert all(status.is_terminal for status in store.sweeps.page().items)


def test_migration__that_fails_changes_nothing(own_url: str, tmp_path: Path) -> None:
    Store.open(own_url).close()
    broken = with_next_revision(tmp_path, "raise RuntimeError('half way')")
    with closing(Database(own_url, broken, "next")) as database:
        with pytest.raises(RuntimeError, match="half way"):
            database.migrate()
        assert database.revision() == REVISION
        with database.reading() as reading:
            columns = {column["name"] for column in sa.inspect(reading).get_columns("sweeps")}
    assert columns == set(SWEEPS.c.keys())


@pytest.mark.parametrize("migrate", [True, False])
def test_unknown_revision__is_refused_with_the_cure_and_left_alone(own_url: str, migrate: bool) -> None:
    revision = "9999"
    with closing(Store.open(own_url)) as store:
        database = store.database
        with database.writing() as writing:
            writing.exec_driver_sql(f"UPDATE alembic_version SET version_num = '{revision}'")
        with pytest.raises(StoreUnavailable) as refused:
            Store.open(own_url, migrate=migrate)
        assert database.revision() == revision
    place = str(sa.make_url(own_url).database)
    for part in (
        place,
        f"revision {revision}",
        f"needs {REVISION}",
        "nothing was changed",
        "keep it",
        "new data directory",
    ):
        assert part in str(refused.value)


def test_empty_database__gets_tables_on_request_alone(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'empty.db'}"
    with pytest.raises(StoreUnavailable, match="start the service"):
        Store.open(url, migrate=False)
    assert Store.revision(url) is None
    Store.open(url).close()
    assert Store.revision(url) == REVISION
