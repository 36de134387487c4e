"""The file of an SQLite database that is open, while somebody removes it, replaces it and puts it back."""

import os
import shutil
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
import sqlalchemy as sa

from service.records.jobs import Submission
from service.store import DatabaseFileLost, Store
from service.store.tables import CONTROL
from tests.service.support.fakes import sweep_of


def remove(database: Path) -> None:
    database.rename(database.with_name("away"))


def replace(database: Path) -> None:
    """By a copy, as a restore does."""
    remove(database)
    shutil.copy(database.with_name("away"), database)


def remove_log(database: Path) -> None:
    remove(Path(f"{database}-wal"))


HARMS: dict[str, tuple[Callable[[Path], None], str, str]] = {
    "removed": (remove, "whipple.db", "was removed"),
    "replaced": (replace, "whipple.db", "was replaced by another file"),
    "log removed": (remove_log, "whipple.db-wal", "was removed"),
}


@pytest.mark.parametrize("harm", HARMS)
def test_database__whose_file_is_not_the_open_one_takes_and_gives_nothing(
    tmp_path: Path, sqlite_url: str, harm: str
) -> None:
    do, name, says = HARMS[harm]
    with closing(Store.open(sqlite_url)) as store:
        accepted = store.sweeps.create(Submission(sweep_of(1)))
        do(tmp_path / "whipple.db")
        for use in (
            lambda: store.sweeps.create(Submission(sweep_of(2))),
            store.sweeps.page,
            store.ping,
            lambda: store.terms.begin("tests"),
        ):
            with pytest.raises(DatabaseFileLost, match=f"{name}, .*{says}.*put it back"):
                use()
        os.replace(tmp_path / "away", tmp_path / name)
        assert store.sweeps.page().items == (accepted,)
        store.sweeps.create(Submission(sweep_of(2)))


def test_writer__is_refused_if_the_file_goes_before_its_commit(tmp_path: Path, sqlite_url: str) -> None:
    def write() -> None:
        with store.database.writing() as connection:
            connection.execute(CONTROL.update().values(forgettable=1))
            remove(tmp_path / "whipple.db")

    with closing(Store.open(sqlite_url)) as store, pytest.raises(DatabaseFileLost):
        write()


def test_connection__to_another_file_is_refused_and_closed(tmp_path: Path, sqlite_url: str) -> None:
    with closing(Store.open(sqlite_url)) as store:
        with store.database.reading():  # the only connection so far is taken
            replace(tmp_path / "whipple.db")
            with pytest.raises(DatabaseFileLost), store.database._engine.connect():
                pass
        store.database._engine.dispose()


def test_store__that_is_closed_may_be_opened_again_with_a_new_log(sqlite_url: str) -> None:
    """SQLite removes the log with the last connection, and makes another."""
    store = Store.open(sqlite_url)
    for _ in range(2):
        store.ping()
        store.close()
        with closing(Store.open(sqlite_url)) as other:
            other.ping()
            with other.database.reading() as connection:
                assert connection.execute(sa.select(sa.func.count()).select_from(CONTROL)).scalar_one() == 1
