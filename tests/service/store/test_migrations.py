"""The tables: made, brought up to date, and refused unchanged where their revision is not known."""

import shutil
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext

from service import migrations
from service.records.jobs import Cause, StoreUnavailable
from service.store import Store
from service.store.connection import Database
from service.store.tables import JOBS, SWEEPS, TABLES
from tests.service.support.databases import Postgresql
from tests.service.support.fakes import runs_of, sweep_of
from tests.service.support.rows import finish_all

NEXT = """
import sqlalchemy as sa
from alembic import op

revision, down_revision = "next", "0005"


def upgrade():
    op.add_column("sweeps", sa.Column("note", sa.Text, nullable=False, server_default="none"))
    {more}
"""


@pytest.fixture
def postgresql_url(postgresql: Postgresql) -> Iterator[str]:
    """A database of its own: these tests change its tables."""
    with postgresql.database() as url:
        yield url


def with_next_revision(folder: Path, more: str = "") -> str:
    """The migrations and one more step, as the location that alembic is given."""
    copied = shutil.copytree(Path(migrations.__file__).parent, folder / "migrations")
    (copied / "versions" / "next.py").write_text(NEXT.format(more=more))
    return str(copied)


def test_upgrade__everything_that_was_accepted_stays_and_can_be_finished(
    store: Store, database_url: str, tmp_path: Path
) -> None:
    done = store.create_sweep(sweep_of(runs_of("fine")))
    finish_all(store)
    waiting = store.create_sweep(sweep_of(runs_of("fine", first=10)))
    [held] = store.claim(1, store.begin_epoch("before"))
    before = [store.sweep(row.id) for row in (done, waiting)]
    with closing(Database(database_url, with_next_revision(tmp_path))) as database:
        database.migrate()
        assert database.revision() == "next"
        with database.reading() as reading:
            assert set(
                reading.execute(sa.select(sa.column("note")).select_from(SWEEPS)).scalars()
            ) == {"none"}
    assert [store.sweep(row.id) for row in (done, waiting)] == before
    store.requeue(held, Cause.LOST, reason="the service was gone")
    finish_all(store)
    assert all(row.is_terminal for row in store.sweeps().items)


def test_upgrade__that_fails_changes_nothing(database_url: str, tmp_path: Path) -> None:
    Store.open(database_url).close()
    broken = with_next_revision(tmp_path, "raise RuntimeError('half way')")
    with closing(Database(database_url, broken)) as database:
        with pytest.raises(RuntimeError, match="half way"):
            database.migrate()
        assert database.revision() == "0005"
        with database.reading() as reading:
            columns = {column["name"] for column in sa.inspect(reading).get_columns("sweeps")}
    assert columns == set(SWEEPS.c.keys())


@pytest.mark.parametrize("migrate", [True, False])
@pytest.mark.parametrize("found", ["0004", "9999"])
def test_revision__that_is_not_known_is_refused_with_the_cure_and_left_alone(
    database_url: str, tmp_path: Path, found: str, migrate: bool
) -> None:
    with closing(Store.open(database_url)) as store, store._database.writing() as writing:
        writing.exec_driver_sql(f"UPDATE alembic_version SET version_num = '{found}'")
    files = {file: file.read_bytes() for file in tmp_path.iterdir()}
    with pytest.raises(StoreUnavailable) as refused:
        Store.open(database_url, migrate=migrate)
    place = sa.make_url(database_url).database
    for part in (str(place), f"revision {found}", "needs 0005", "new data directory", "open_cube"):
        assert part in str(refused.value)
    assert Store.revision(database_url) == found
    assert {file: file.read_bytes() for file in tmp_path.iterdir()} == files


def test_revision__of_an_empty_database_is_none_and_it_is_not_made_unasked(sqlite_url: str) -> None:
    assert Store.revision(sqlite_url) is None
    with pytest.raises(StoreUnavailable, match="start the service"):
        Store.open(sqlite_url, migrate=False)
    assert Store.revision(sqlite_url) is None


def test_tables__are_those_that_the_queries_expect(store: Store) -> None:
    with store._database.reading() as reading:
        options = {"compare_type": True, "include_object": _is_not_version}
        context = MigrationContext.configure(reading, opts=options)
        assert compare_metadata(context, TABLES) == []


def _is_not_version(_object: Any, name: str | None, *_rest: Any) -> bool:
    return name != "alembic_version"


def test_opening_again__changes_nothing(store: Store, database_url: str) -> None:
    row = store.create_sweep(sweep_of(1))
    with closing(Store.open(database_url)) as again:
        assert again.sweep(row.id).planned == 1
        with again._database.reading() as reading:
            assert reading.execute(sa.select(sa.func.count()).select_from(JOBS)).scalar() == 2
