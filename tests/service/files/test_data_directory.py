"""The lock of a data directory, and of a database with several names."""

import os
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from service.cli.local import run_sweep
from service.cli.serve import serve
from service.files.data_directory import DataInUse, holding
from service.settings import Settings
from service.store import Store
from studies.quantities.findings import InvalidInput
from tests.service.support.api import SWEEP


def run_sweep_in(settings: Settings) -> None:
    run_sweep(SWEEP, settings.data, settings=settings)


def test_second__is_refused_and_told_by_whom(tmp_path: Path) -> None:
    settings = Settings(data=tmp_path)
    linked = Settings(data=tmp_path / "two", database_url=f"sqlite:///{tmp_path / 'two/linked.db'}")
    linked.data.mkdir()
    (linked.data / "linked.db").symlink_to(tmp_path / "whipple.db")
    with holding(settings):
        refusal = f"process {os.getpid()}; stop it, or choose another"
        for second in (settings, linked):
            with pytest.raises(DataInUse, match=refusal), holding(second):
                pass  # never reached


@pytest.mark.parametrize("begin", [serve, run_sweep_in])
def test_hard_link__is_refused_before_the_database_is_touched(
    tmp_path: Path, begin: Callable[[Settings], object]
) -> None:
    settings = Settings(data=tmp_path / "data", port=0)
    settings.data.mkdir()
    database = settings.data / "whipple.db"
    database.touch()
    (tmp_path / "other.db").hardlink_to(database)
    with pytest.raises(InvalidInput, match="without hard links"):
        begin(settings)
    assert list(settings.data.iterdir()) == [database]
    assert database.stat().st_size == 0


def test_postgresql__several_services_share_a_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir("/")  # as systemd starts a service
    settings = Settings(data=tmp_path, database_url="postgresql+psycopg://nobody@localhost/none")
    with holding(settings), holding(settings):
        assert not (tmp_path / "whipple.lock").exists()


def test_data__is_for_its_owner_alone_and_what_was_open_is_tightened(tmp_path: Path) -> None:
    settings = Settings(data=tmp_path / "data")
    settings.data.mkdir(mode=0o755)
    for name in ("whipple.db", "whipple.db-wal"):
        (settings.data / name).touch(0o644)
        (settings.data / name).chmod(0o644)
    with holding(settings), closing(Store.open(settings.url)) as store:
        store.ping()
        modes = {file.name: file.stat().st_mode & 0o777 for file in settings.data.glob("*.db*")}
        assert modes == dict.fromkeys(("whipple.db", "whipple.db-wal", "whipple.db-shm"), 0o600)
        store.database.copy_to(tmp_path / "copy.db")
    assert settings.data.stat().st_mode & 0o777 == 0o700
    assert (tmp_path / "copy.db").stat().st_mode & 0o777 == 0o600


def test_data__that_workers_may_share_by_their_group_keeps_it(tmp_path: Path) -> None:
    settings = Settings(data=tmp_path / "data", database_url="postgresql+psycopg://nobody@nowhere/x")
    settings.data.mkdir()
    settings.data.chmod(0o2775)
    with holding(settings):
        assert settings.data.stat().st_mode & 0o777 == 0o770
