"""The doctor finds what a test broke, names it, and says what to do; and changes nothing."""

import os
import resource
from collections.abc import Iterator
from datetime import UTC, datetime, timedelta
from pathlib import Path
from types import SimpleNamespace

import pytest
from pydantic import ByteSize

from service import doctor, execution, space
from service.artifacts import Artifacts
from service.doctor import CHECKS, Check, Verdict, examine
from service.jobs import Cause, Schema, Stored
from service.settings import Settings
from service.store import Store
from tests.service.bench import Bench, open_bench
from tests.service.doubles import run_id, runs_of, sweep_of

ELSEWHERE = "tls://scheduler.example.org:8786"


@pytest.fixture
def bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Bench]:
    """A store with a run that has a result and one that failed."""
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    with open_bench(tmp_path) as opened:
        opened.store.create_sweep(sweep_of(runs_of("fine", "raise")))
        good, bad = opened.turn()
        opened.end_well(good)
        opened.end_badly(bad, Cause.ERROR)
        opened.end_well(opened.turn()[0])
        opened.turn()
        yield opened


def ask(check: str, settings: Settings, *, every_file: bool = False) -> Check:
    """What one check finds, if it is one thing."""
    [found] = CHECKS[check](settings, every_file)
    return found


def examined(check: str, settings: Settings) -> Check:
    """The same as part of an examination, which catches what is raised."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(doctor, "CHECKS", {check: CHECKS[check]})
        [found] = examine(settings)
    return found


def all_files(folder: Path) -> dict[str, int]:
    return {str(file): file.stat().st_mtime_ns for file in folder.rglob("*") if file.is_file()}


def test_all_is_well__every_check_says_so_and_nothing_is_changed(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(CHECKS, "kernels", lambda _settings, _every: iter(()))  # asked below
    before = all_files(bench.settings.data)
    found = list(examine(bench.settings, every_file=True))
    assert {one.verdict for one in found} == {Verdict.FINE}, found
    assert {one.name for one in found} == {*CHECKS} - {"kernels"}
    assert not [one.cure for one in found if one.cure]
    assert all_files(bench.settings.data) == before


def test_unforeseen__is_a_finding_and_the_rest_is_looked_at(
    bench: Bench, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stumble(_settings: Settings, _every: bool) -> Iterator[Check]:
        raise RuntimeError("nobody foresaw this")

    monkeypatch.setattr(doctor, "CHECKS", {"one": stumble, "disk": CHECKS["disk"]})
    one, disk = examine(bench.settings)
    assert (one.verdict, disk.verdict) == (Verdict.WRONG, Verdict.FINE)
    assert "nobody foresaw this" in one.detail


# --- directory, disk, limits -----------------------------------------------------------------------


def test_directory__that_is_not_there(tmp_path: Path) -> None:
    found = ask("data directory", Settings(data=tmp_path / "nowhere"))
    assert found.verdict is Verdict.WRONG
    assert str(tmp_path / "nowhere") in found.cure


@pytest.mark.parametrize(("kind", "several", "verdict"), [
    ("ext4", False, Verdict.FINE),
    ("nfs4", False, Verdict.WRONG),
    ("nfs4", True, Verdict.FINE),
])  # fmt: skip
def test_filesystem__a_networks_disk_is_nothing_for_sqlite(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, several: bool, verdict: Verdict
) -> None:
    mounts = tmp_path / "mounts"
    mounts.write_text(f"/dev/x / ext3 rw 0 0\nserver:/y {tmp_path.resolve()} {kind} rw 0 0\n")
    monkeypatch.setattr(doctor, "MOUNTS", mounts)
    url = "postgresql+psycopg://a/b" if several else None
    found = ask("filesystem", Settings(data=tmp_path, database_url=url))
    assert found.verdict is verdict
    assert found.detail.startswith(kind)


def test_filesystem__locks_that_do_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor.fcntl, "flock", lambda _file, _how: None)
    assert ask("filesystem", Settings(data=tmp_path)).verdict is Verdict.WRONG


@pytest.mark.parametrize(
    ("free", "verdict"), [(0.5, Verdict.WRONG), (1.5, Verdict.WARNING), (2.5, Verdict.FINE)]
)
def test_disk__against_the_reserve(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, free: float, verdict: Verdict
) -> None:
    size = int(free * 2**30)
    monkeypatch.setattr(space.shutil, "disk_usage", lambda _folder: SimpleNamespace(free=size))
    assert ask("disk", Settings(data=tmp_path)).verdict is verdict


def test_open_files__a_low_limit_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor.resource, "getrlimit", lambda _which: (64, 128))
    found = ask("open files", Settings(workers=1))
    assert found.verdict is Verdict.WARNING
    assert "ulimit -n" in found.cure


def test_open_files__no_limit_is_fine(monkeypatch: pytest.MonkeyPatch) -> None:
    without = resource.RLIM_INFINITY
    monkeypatch.setattr(doctor.resource, "getrlimit", lambda _which: (without, without))
    assert ask("open files", Settings()).verdict is Verdict.FINE


# --- database and clock ----------------------------------------------------------------------------


def test_database__that_is_not_there_is_not_made(tmp_path: Path) -> None:
    assert ask("database", Settings(data=tmp_path)).verdict is Verdict.WARNING
    assert not [*CHECKS["files"](Settings(data=tmp_path), False)]
    assert [*tmp_path.iterdir()] == []


def test_database__that_is_no_database(tmp_path: Path) -> None:
    (tmp_path / "whipple.db").write_bytes(b"not a database" * 100)
    assert examined("database", Settings(data=tmp_path)).verdict is Verdict.WRONG


@pytest.mark.parametrize(("found", "verdict"), [("0000", Verdict.WARNING), ("9999", Verdict.WRONG)])
def test_database__of_another_version(
    bench: Bench, monkeypatch: pytest.MonkeyPatch, found: str, verdict: Verdict
) -> None:
    newest = Store.schema(bench.settings.url).newest
    monkeypatch.setattr(Store, "schema", lambda _url: Schema(found, newest))
    assert ask("database", bench.settings).verdict is verdict


def test_database__of_postgresql_that_is_away(tmp_path: Path) -> None:
    away = Settings(data=tmp_path, database_url="postgresql+psycopg://nobody@127.0.0.1:9/none")
    assert examined("database", away).verdict is Verdict.WRONG


def test_database__of_postgresql_that_answers(tmp_path: Path, postgresql_url: str) -> None:
    settings = Settings(data=tmp_path, database_url=postgresql_url)
    assert ask("database", settings).verdict is Verdict.FINE
    assert ask("files", settings).verdict is Verdict.FINE


def test_clock__that_was_set_back(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    yesterday = datetime.now(UTC) - timedelta(days=1)
    monkeypatch.setattr(doctor, "datetime", SimpleNamespace(now=lambda _zone: yesterday))
    found = ask("clock", bench.settings)
    assert found.verdict is Verdict.WARNING
    assert "set back" in found.detail


def test_clock__of_a_disk_that_differs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "_time_of_disk", lambda _folder: 1e9)
    assert ask("clock", Settings(data=tmp_path)).verdict is Verdict.WARNING


# --- files -----------------------------------------------------------------------------------------


def test_files__that_are_damaged_or_lost_are_named(bench: Bench) -> None:
    artifacts = Artifacts(bench.settings.data)
    damaged = artifacts.path(bench.store.run_file(run_id(0), "state.npz"))
    lost = artifacts.path(bench.store.run_file(run_id(0), "result.json"))
    damaged.write_bytes(b"x" * damaged.stat().st_size)
    lost.unlink()
    found = ask("files", bench.settings, every_file=True)
    assert found.verdict is Verdict.WRONG
    assert found.detail.startswith("2 of")
    assert {artifacts.relative(damaged), artifacts.relative(lost)} == {
        word.rstrip(",") for word in found.detail.split() if word.startswith("runs/")
    }


def test_files__a_sample_is_spread_over_all(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "SAMPLE", 2)
    looked: list[str] = []

    def look(_self: Artifacts, file: Stored) -> bool:
        looked.append(file.path)
        return True

    monkeypatch.setattr(Artifacts, "is_intact", look)
    number = len(bench.store.files())
    assert number >= 4
    ask("files", bench.settings)
    assert 2 <= len(looked) < number


def test_orphans__strangers_are_named(bench: Bench) -> None:
    artifacts = Artifacts(bench.settings.data)
    for folder in (artifacts.run_folder(run_id(77)), artifacts.sweep_folder(run_id(78))):
        (folder / "a1-c0ffee00").mkdir(parents=True)
    found = ask("orphans", bench.settings)
    assert found.verdict is Verdict.WARNING
    assert found.detail.startswith("2 ")
    assert "database" in found.cure


def test_orphans__what_waits_to_be_removed_is_fine_and_what_should_be_gone_is_not(
    bench: Bench,
) -> None:
    folder = Artifacts(bench.settings.data).run_folder(run_id(0)) / "a0-c0ffee00"
    folder.mkdir()
    assert ask("orphans", bench.settings).verdict is Verdict.FINE
    os.utime(folder, (0, 0))
    assert ask("orphans", bench.settings).verdict is Verdict.WARNING


def test_orphans__the_store_is_not_brought_up_to_date(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = Settings(data=tmp_path)
    Store.open(settings.url).close()
    monkeypatch.setattr(Store, "schema", lambda _url: Schema("0001", "0002"))
    assert [*CHECKS["orphans"](settings, False)] == []


# --- engine and kernels ----------------------------------------------------------------------------


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
def test_engine__that_answers(
    elsewhere: Settings,
    monkeypatch: pytest.MonkeyPatch,
    workers: dict[str, str],
    verdict: Verdict,
) -> None:
    answer = execution.Cluster(ELSEWHERE, workers)
    monkeypatch.setattr(execution, "probe", lambda _settings: answer)
    found = ask("engine", elsewhere)
    assert found.verdict is verdict
    assert ("numpy 1, here 2" in found.detail) == ("numpy 1, here 2" in workers.values())


def test_engine__that_does_not(elsewhere: Settings, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_settings: Settings) -> execution.Cluster:
        raise ConnectionRefusedError("nobody is there")

    monkeypatch.setattr(execution, "probe", refuse)
    found = ask("engine", elsewhere)
    assert found.verdict is Verdict.WRONG
    assert "nobody is there" in found.detail


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_engine__certificates_that_cannot_be_read(elsewhere: Settings) -> None:
    assert elsewhere.tls_key is not None
    elsewhere.tls_key.chmod(0)
    found = [*CHECKS["engine"](elsewhere, False)]
    assert str(elsewhere.tls_key) in found[0].detail


def test_kernels__not_compiled_yet(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("WHIPPLE_KERNEL_CACHE", str(tmp_path))
    found = ask("kernels", Settings())
    assert found.verdict is Verdict.WARNING
    assert str(tmp_path) in found.detail
    assert "whipple warm" in found.cure


def test_kernels__a_solver_that_does_not_load(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "KERNELS", "raise ImportError('no numba here')")
    found = ask("kernels", Settings())
    assert found.verdict is Verdict.WRONG
    assert "no numba here" in found.detail
