"""The doctor finds what a test broke, names it, and says what to do; and changes nothing."""

from contextlib import closing
from pathlib import Path

import pytest
from pydantic import ByteSize

from service import execution
from service.cli.doctor import Check, Verdict, check_directory, check_store, check_workers, examine
from service.queue import data_identity as identity
from service.records.settings import Settings
from service.store import Store

ELSEWHERE = "tls://scheduler.example.org:8786"


@pytest.fixture
def settings(tmp_path: Path) -> Settings:
    """A data directory and its store."""
    settings = Settings(data=tmp_path, workers=2)
    with closing(Store.open(settings.url)) as store:
        identity.settle(settings, store)
    return settings


def all_files(folder: Path) -> dict[str, int]:
    return {str(file): file.stat().st_mtime_ns for file in folder.rglob("*") if file.is_file()}


def test_all_is_well__every_check_says_so_and_nothing_is_changed(settings: Settings) -> None:
    before = all_files(settings.data)
    found = list(examine(settings))
    assert [(one.name, one.verdict, one.cure) for one in found] == [
        (name, Verdict.FINE, "") for name in ("data directory", "store", "workers")
    ]
    assert all_files(settings.data) == before


def test_directory__that_is_not_there(tmp_path: Path) -> None:
    [found] = check_directory(Settings(data=tmp_path / "nowhere"))
    assert found.verdict is Verdict.WRONG
    assert str(tmp_path / "nowhere") in found.cure


def test_store__that_is_not_there_is_not_made(tmp_path: Path) -> None:
    [found] = check_store(Settings(data=tmp_path))
    assert found.verdict is Verdict.WARNING
    assert [*tmp_path.iterdir()] == []


def test_store__that_is_no_database(tmp_path: Path) -> None:
    (tmp_path / "whipple.db").write_bytes(b"not a database" * 100)
    [found] = check_store(Settings(data=tmp_path))
    assert found.verdict is Verdict.WRONG


def test_store__of_another_revision(settings: Settings) -> None:
    with closing(Store.open(settings.url)) as store, store._database.writing() as writing:
        writing.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
    [found] = check_store(settings)
    assert found.verdict is Verdict.WRONG
    assert "9999" in found.detail


def test_store__of_another_directory(settings: Settings) -> None:
    identity.write(settings.data, "another")
    [found] = check_store(settings)
    assert found.verdict is Verdict.WRONG
    assert "another" in found.detail


def test_store__on_postgresql_that_is_away(tmp_path: Path) -> None:
    url = "postgresql+psycopg://nobody@127.0.0.1:9/none"
    [found] = check_store(Settings(data=tmp_path, database_url=url))
    assert found.verdict is Verdict.WRONG


def test_store__on_postgresql_that_answers(tmp_path: Path, postgresql_url: str) -> None:
    settings = Settings(data=tmp_path, database_url=postgresql_url)
    with closing(Store.open(settings.url)) as store:
        identity.settle(settings, store)
    [found] = check_store(settings)
    assert found.verdict is Verdict.FINE


def ask_workers(settings: Settings) -> Check:
    [found] = check_workers(settings)
    return found


@pytest.fixture
def elsewhere(tmp_path: Path) -> Settings:
    file = tmp_path / "own.pem"
    file.touch()
    return Settings(
        data=tmp_path,
        engine=ELSEWHERE,
        tls_ca=file,
        tls_cert=file,
        tls_key=file,
        memory_limit=ByteSize(1 << 30),
    )


@pytest.mark.parametrize(("workers", "verdict"), [
    ({"a": "", "b": ""}, Verdict.FINE),
    ({}, Verdict.WARNING),
    ({"a": "", "b": "numpy 1, here 2"}, Verdict.WARNING),
    ({"b": "numpy 1, here 2"}, Verdict.WRONG),
])  # fmt: skip
def test_workers__on_an_engine_that_answers(
    elsewhere: Settings,
    monkeypatch: pytest.MonkeyPatch,
    workers: dict[str, str],
    verdict: Verdict,
) -> None:
    answer = execution.Cluster(ELSEWHERE, workers)
    monkeypatch.setattr(execution, "probe", lambda _settings: answer)
    found = ask_workers(elsewhere)
    assert found.verdict is verdict
    assert ("numpy 1, here 2" in found.detail) == ("numpy 1, here 2" in workers.values())


def test_workers__on_an_engine_that_does_not(
    elsewhere: Settings, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_settings: Settings) -> execution.Cluster:
        raise ConnectionRefusedError("nobody is there")

    monkeypatch.setattr(execution, "probe", refuse)
    found = ask_workers(elsewhere)
    assert found.verdict is Verdict.WRONG
    assert "nobody is there" in found.detail
