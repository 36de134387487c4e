"""Databases: durability, waits that end, tables that are made, migrated or refused."""

import shutil
import threading
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
import sqlalchemy as sa

from service import migrations
from service.records.jobs import Cause, Kind, StoreUnavailable, Submission
from service.store import Store, connection
from service.store.connection import Database
from service.store.tables import JOBS, OWNED_BYTES, REVISION, SWEEPS, now
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


# From the tables of this version back to those of 0010, and from there to 0006.
TRIGGERS = ("files_added", "files_removed", "files_replaced", "jobs_moved")
TO_0010 = """
DROP TABLE owned_bytes
DROP TABLE results
DROP INDEX jobs_states
DROP INDEX jobs_active
DROP INDEX jobs_abandoned
DROP INDEX jobs_published
DROP INDEX jobs_queue
CREATE INDEX jobs_abandoned ON jobs (abandoned)
CREATE INDEX jobs_queue ON jobs (state, priority, owner, virtual_time, ordinal)
ALTER TABLE sweeps DROP COLUMN physics
ALTER TABLE sweeps DROP COLUMN renewed
ALTER TABLE sweeps DROP COLUMN older
ALTER TABLE control DROP COLUMN clock
UPDATE alembic_version SET version_num = '0010'
"""
TO_THE_OLDEST = """
DROP TABLE audit
DROP TABLE sessions
DROP TABLE shares
DROP INDEX jobs_queue
ALTER TABLE jobs DROP COLUMN owner
ALTER TABLE sweeps DROP COLUMN pinned
ALTER TABLE control DROP COLUMN scrub
CREATE INDEX jobs_queue ON jobs (state, priority, virtual_time, ordinal)
CREATE TABLE priority_classes (priority INTEGER PRIMARY KEY, virtual_time FLOAT NOT NULL)
INSERT INTO priority_classes VALUES (0, 7.0)
UPDATE alembic_version SET version_num = '0006'
"""


def put_back(store: Store, *steps: str) -> None:
    """Bring the tables of a store back to those of an earlier revision."""
    drop = "DROP TRIGGER {}" if store.database.is_sqlite else "DROP FUNCTION {} CASCADE"
    with store.database.writing() as writing:
        for statement in (*map(drop.format, TRIGGERS), *"".join(steps).strip().splitlines()):
            writing.exec_driver_sql(statement.strip() or "SELECT 1")


def test_migration__of_the_oldest_tables_makes_those_of_this_version_and_goes_on(own_url: str) -> None:
    with closing(Store.open(own_url)) as store:
        accepted = store.sweeps.create(Submission(sweep_of(runs_of("fine")), owner="a"))
        before = sa.MetaData()
        with store.database.reading() as reading:
            before.reflect(reading)
        triggers = triggers_of(store)
        put_back(store, TO_0010, TO_THE_OLDEST)
    with closing(Store.open(own_url)) as store:
        assert store.sweeps.get(accepted.id) == replace(accepted, physics=None)  # which was not noted then
        after = sa.MetaData()
        with store.database.reading() as reading:
            after.reflect(reading)
        store.terms.begin("tests")
        finish_all(store)
        assert store.sweeps.get(accepted.id).is_terminal
        assert triggers_of(store) == triggers
        assert store.retention.wrong_sums() == {}
    assert described(after) == described(before)


def described(tables: sa.MetaData) -> set[tuple[object, ...]]:
    """Every column with its type, and whether it may be empty; every index with its columns and condition."""
    columns = {
        (table.name, column.name, str(column.type), bool(column.nullable))
        for table in tables.tables.values()
        for column in table.c
    }
    indexes = {
        (index.name, *index.columns.keys(), *(str(each.get("where")) for each in index.dialect_options.values()))
        for table in tables.tables.values()
        for index in table.indexes
    }
    return columns | indexes


def triggers_of(store: Store) -> list[str]:
    query = "SELECT sql FROM sqlite_master WHERE type = 'trigger' ORDER BY name"
    if not store.database.is_sqlite:
        query = "SELECT pg_get_triggerdef(oid) FROM pg_trigger WHERE NOT tgisinternal ORDER BY tgname"
    with store.database.reading() as reading:
        return list(reading.scalars(sa.text(query)))


def test_migration__to_sums_counts_what_is_there_and_gives_each_run_an_owner_who_has_it(own_url: str) -> None:
    with closing(Store.open(own_url)) as store:
        store.terms.begin("tests")
        gone = store.sweeps.create(Submission(sweep_of(2), owner="a"))
        finish_all(store)
        store.sweeps.create(Submission(sweep_of(1), owner="b"))
        finish_all(store)
        counted, rate = store.queue.tally(), store.runs.measured_rate("thin_plate")
        store.sweeps.delete(gone.id)
        bytes_of_b = owned_bytes(store)
        with store.database.writing() as writing:  # as 0010 left it
            writing.execute(JOBS.update().where(JOBS.c.kind == Kind.RUN).values(owner="a", abandoned=now()))
        put_back(store, TO_0010)
    with closing(Store.open(own_url)) as store:
        assert (store.queue.tally(), store.runs.measured_rate("thin_plate")) == (counted, rate)
        assert counted[0].attempts == 2
        assert owned_bytes(store) == bytes_of_b
        assert bytes_of_b["b"] == 2 * len(b"...")
        assert store.retention.wrong_sums() == {}


def owned_bytes(store: Store) -> dict[str, int]:
    """The kept sums, without zeros."""
    with store.database.reading() as reading:
        return {row.owner: row.bytes for row in reading.execute(sa.select(OWNED_BYTES)) if row.bytes}


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
@pytest.mark.parametrize("revision", ["0005", "9999"])
def test_unknown_revision__is_refused_with_the_cure_and_left_alone(
    own_url: str, tmp_path: Path, revision: str, migrate: bool
) -> None:
    with closing(Store.open(own_url)) as store, store.database.writing() as writing:
        writing.exec_driver_sql(f"UPDATE alembic_version SET version_num = '{revision}'")
    files = {file: file.read_bytes() for file in tmp_path.glob("*.db")}
    with pytest.raises(StoreUnavailable) as refused:
        Store.open(own_url, migrate=migrate)
    place = str(sa.make_url(own_url).database)
    for part in (place, f"revision {revision}", f"needs {REVISION}", "new data directory", "open_cube"):
        assert part in str(refused.value)
    assert Store.revision(own_url) == revision
    assert {file: file.read_bytes() for file in tmp_path.glob("*.db")} == files


def test_empty_database__gets_tables_on_request_alone(tmp_path: Path) -> None:
    url = f"sqlite:///{tmp_path / 'empty.db'}"
    with pytest.raises(StoreUnavailable, match="start the service"):
        Store.open(url, migrate=False)
    assert Store.revision(url) is None
    Store.open(url).close()
    assert Store.revision(url) == REVISION
