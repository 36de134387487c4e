"""The doctor finds what a test broke, names it, and says what to do; and changes nothing."""

import sqlite3
from contextlib import closing
from pathlib import Path
from unittest.mock import Mock

import pytest
from pydantic import ByteSize

from service import execution
from service.maintenance.doctor import CheckStatus, check_store, check_workers, examine
from service.queue import data_identity as identity
from service.records.jobs import Scrub
from service.settings import Settings
from service.store import Store

ELSEWHERE = "tls://scheduler.example.org:8786"


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    settings = Settings(data=tmp_path, workers=2)
    with closing(Store.open(settings.url)) as store:
        identity.settle(settings, store)
    return settings


def all_files(folder: Path) -> dict[str, int]:
    return {str(file): file.stat().st_mtime_ns for file in folder.rglob("*") if file.is_file()}


def test_all_is_well__every_check_says_so_and_nothing_is_changed(settings: Settings) -> None:
    before = all_files(settings.data)
    result = list(examine(settings))
    assert [(item.name, item.status, item.cure) for item in result] == [
        (name, CheckStatus.OK, "") for name in ("data directory", "database", "stored files", "workers")
    ]
    assert all_files(settings.data) == before


@pytest.mark.parametrize("damaged", [0, 2])
def test_files__were_compared_then_and_so_many_are_damaged(settings: Settings, damaged: int) -> None:
    with closing(Store.open(settings.url)) as store:
        store.retention.note_scrub(Scrub(whole=(86400.0, 7, damaged)))
    result = list(check_store(settings))[1]
    assert result.status is (CheckStatus.WARNING if damaged else CheckStatus.OK)
    assert result.detail == f"7 compared with their digests until 1970-01-02 00:00 UTC, {damaged} damaged"
    assert ("forget-lost" in result.cure) is bool(damaged)


def test_store__that_is_not_there_is_not_made(tmp_path: Path) -> None:
    [result] = check_store(Settings(data=tmp_path))
    assert result.status is CheckStatus.WARNING
    assert [*tmp_path.iterdir()] == []


def test_store__that_is_another_one_or_none(settings: Settings, tmp_path: Path) -> None:
    identity.write(settings.data, "another")
    away = Settings(data=tmp_path, database_url="postgresql+psycopg://nobody@127.0.0.1:9/none")
    [other], [absent] = check_store(settings), check_store(away)
    (tmp_path / "whipple.db").write_bytes(b"not a database" * 100)
    [broken] = check_store(settings)
    assert {result.status for result in (other, absent, broken)} == {CheckStatus.ERROR}
    assert "another" in other.detail
    assert "restore the last backup" in broken.cure
    assert "restore" not in absent.cure


def test_store__with_a_damaged_page_is_restored_from_a_backup(settings: Settings) -> None:
    """A page that no question of the doctor reads is read all the same."""
    file = settings.data / "whipple.db"
    pages = bytearray(file.read_bytes())
    with closing(sqlite3.connect(file)) as connection:
        [(size,)] = connection.execute("PRAGMA page_size")
        [(root,)] = connection.execute("SELECT rootpage FROM sqlite_master WHERE name = 'points'")
    pages[(root - 1) * size : root * size] = b"\xff" * size
    file.write_bytes(pages)
    [damaged] = check_store(settings)
    assert damaged.status is CheckStatus.ERROR
    for word in ("restore the last backup", str(settings.data.absolute()), "stop the service"):
        assert word in damaged.cure


@pytest.fixture
def elsewhere(tmp_path: Path) -> Settings:
    file = tmp_path / "own.pem"
    file.touch()
    return Settings(
        data=tmp_path, engine=ELSEWHERE, tls_ca=file, tls_cert=file, tls_key=file, memory_limit=ByteSize(1 << 30)
    )


@pytest.mark.parametrize(("workers", "status"), [
    ({"a": "", "b": ""}, CheckStatus.OK),
    ({}, CheckStatus.WARNING),
    ({"a": "", "b": "numpy 1, here 2"}, CheckStatus.WARNING),
    ({"b": "numpy 1, here 2"}, CheckStatus.ERROR),
])  # fmt: skip
def test_workers__on_an_engine_that_answers(
    elsewhere: Settings, monkeypatch: pytest.MonkeyPatch, workers: dict[str, str], status: CheckStatus
) -> None:
    monkeypatch.setattr(execution, "probe", lambda _settings: workers)
    [result] = check_workers(elsewhere)
    assert result.status is status
    assert ("numpy 1, here 2" in result.detail) == ("numpy 1, here 2" in workers.values())
    refusing = Mock(side_effect=ConnectionRefusedError("nobody is there"))
    monkeypatch.setattr(execution, "probe", refusing)
    [result] = check_workers(elsewhere)
    assert (result.status, "nobody is there" in result.detail) == (CheckStatus.ERROR, True)
