"""Databases: durability, waits that end, tables that are made, migrated or refused."""

import shutil
import sqlite3
import threading
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest
import sqlalchemy as sa

from service import migrations
from service.cli.local import run_sweep
from service.cli.serve import serve
from service.records.jobs import Cause, StoreUnavailable, Submission
from service.settings import Settings
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
@pytest.mark.parametrize("revision", ["0012", "9999"])
def test_unknown_revision__is_refused_with_the_cure_and_left_alone(own_url: str, revision: str, migrate: bool) -> None:
    with closing(Store.open(own_url)) as store:
        database = store.database
        with database.writing() as writing:
            writing.exec_driver_sql(f"UPDATE alembic_version SET version_num = '{revision}'")
        before = rows_of(database)
        with pytest.raises(StoreUnavailable) as refused:
            Store.open(own_url, migrate=migrate)
        assert rows_of(database) == before
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


def rows_of(database: Database) -> dict[str, list[sa.Row[tuple[str, ...]]]]:
    """Every row of every table, with those of the catalogue that names the tables."""
    tables = sa.MetaData()
    with database.reading() as reading:
        tables.reflect(reading)
        return {name: [*reading.execute(table.select())] for name, table in tables.tables.items()}


OF_BEFORE = """
CREATE TABLE alembic_version (version_num VARCHAR(32) PRIMARY KEY);
CREATE TABLE sweeps (number INTEGER PRIMARY KEY, id VARCHAR(32));
INSERT INTO alembic_version VALUES ('0012');
INSERT INTO sweeps VALUES (1, 'accepted');
"""


@pytest.mark.parametrize("killed", ["", "PRAGMA user_version = 1", OF_BEFORE])
def test_data_directory__of_an_earlier_version_is_refused_by_every_command_and_no_byte_changes(
    tmp_path: Path, killed: str, smoke: Path
) -> None:
    """Also with a log beside the file, which a service that was ``killed`` leaves."""
    made, data = tmp_path / "made", tmp_path / "data"
    made.mkdir(0o755)
    (made / "whipple.lock").write_text("4711")
    with closing(sqlite3.connect(made / "whipple.db")) as writer:
        if killed != OF_BEFORE:
            writer.executescript(OF_BEFORE)
        if killed:
            writer.executescript(f"PRAGMA journal_mode = WAL; {killed}")
        shutil.copytree(made, data, ignore=shutil.ignore_patterns("*-shm"))
    before = described(data)
    assert (data / "whipple.db-wal").exists() is bool(killed)
    settings = Settings(data=data, port=0)
    commands: list[Callable[[], object]] = [
        lambda: serve(settings),
        lambda: run_sweep(smoke, tmp_path / "out", settings=settings),
        lambda: Store.open(settings.url),
        lambda: Store.open(settings.url, migrate=False),
        lambda: Store.revision(settings.url),
    ]
    for command in commands:
        with pytest.raises(StoreUnavailable, match=r"revision 0012.* nothing was changed: keep it .*new data dir"):
            command()
        assert described(data) == before


def described(folder: Path) -> dict[Path, tuple[int, bytes]]:
    """Mode and content of a folder and of each file in it, but for the index of a log, which readers make anew."""
    places = [place for place in folder.iterdir() if place.suffix != ".db-shm"]
    contents = {place: (place.stat().st_mode, place.read_bytes()) for place in places}
    return {folder: (folder.stat().st_mode, b""), **contents}


def test_empty_database__gets_tables_on_request_alone(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'empty.db'}"
    with pytest.raises(StoreUnavailable, match="start the service"):
        Store.open(url, migrate=False)
    assert Store.revision(url) is None
    Store.open(url).close()
    assert Store.revision(url) == REVISION
