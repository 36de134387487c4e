"""The id that data directory and database share, and what is done where they have two."""

import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from service.files.artifacts import Artifacts
from service.queue import data_identity as identity
from service.queue.data_identity import WrongDirectory
from service.records.jobs import Cause, State
from service.records.settings import Settings
from service.store import Store
from studies.values.errors import InvalidInput
from studies.values.files import STATE
from tests.service.support.api import open_api
from tests.service.support.fakes import settings_in, stored, sweep_of
from tests.service.support.harness import Harness, open_harness
from tests.service.support.rows import finish_all

OTHER = "0123456789abcdef" * 2


@pytest.fixture
def settings(tmp_path: Path, database_url: str) -> Settings:
    return settings_in(tmp_path / "data", database_url=database_url)


@pytest.fixture
def harness(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Harness]:
    """A service whose database is not in its data directory."""
    monkeypatch.setenv("NUMBA_NUM_THREADS", "1")
    monkeypatch.setattr("service.queue.dispatcher.TRY_SECONDS", 0.0)
    with open_harness(tmp_path / "data", database_url=f"sqlite:///{tmp_path / 'x.db'}") as opened:
        identity.settle(opened.settings, opened.store)
        yield opened


# --- at the start ----------------------------------------------------------------------------------


def test_settle__gives_both_one_id_that_stays(settings: Settings, store: Store) -> None:
    identity.settle(settings, store)
    first = store.data_id()
    assert first is not None
    assert identity.read(settings.data) == first
    identity.settle(settings, store)
    assert identity.read(settings.data) == store.data_id() == first


def test_settle__refuses_an_empty_directory_for_results_of_a_store_without_id(
    settings: Settings, store: Store
) -> None:
    store.create_sweep(sweep_of(1))
    finish_all(store)
    settings.data.mkdir()
    with pytest.raises(WrongDirectory, match=r"no results.*mount it, or .*whipple adopt"):
        identity.settle(settings, store)
    assert store.data_id() is None
    assert list(settings.data.iterdir()) == []
    identity.adopt(settings, store)
    identity.settle(settings, store)


def test_settle__refuses_a_directory_that_is_not_there_and_makes_none(
    settings: Settings, store: Store
) -> None:
    identity.settle(settings, store)
    shutil.rmtree(settings.data)
    with pytest.raises(WrongDirectory, match=f"not there.*{store.data_id()}; mount it"):
        identity.settle(settings, store)
    assert not settings.data.exists()


def test_settle__refuses_an_empty_directory_until_it_is_adopted(
    settings: Settings, store: Store
) -> None:
    identity.settle(settings, store)
    known = store.data_id()
    (settings.data / identity.FILE).unlink()
    with pytest.raises(WrongDirectory, match=f"has no id.*the id {known}.*whipple adopt"):
        identity.settle(settings, store)
    assert identity.adopt(settings, store) == known
    identity.settle(settings, store)
    assert store.data_id() == known


def test_settle__refuses_an_empty_database_until_it_is_adopted(
    settings: Settings, store: Store
) -> None:
    settings.data.mkdir()
    identity.write(settings.data, OTHER)
    with pytest.raises(WrongDirectory, match=f"the id {OTHER}.*no id.*whipple adopt"):
        identity.settle(settings, store)
    assert store.data_id() is None
    assert identity.adopt(settings, store) == store.data_id() == OTHER


def test_settle__refuses_the_directory_of_another_database(
    settings: Settings, store: Store
) -> None:
    identity.settle(settings, store)
    known = store.data_id()
    identity.write(settings.data, OTHER)
    with pytest.raises(WrongDirectory, match=f"the id {OTHER}.*the id {known}.*whipple adopt"):
        identity.settle(settings, store)
    assert identity.adopt(settings, store) == identity.read(settings.data) == known


def test_adopt__never_makes_a_directory(settings: Settings, store: Store) -> None:
    with pytest.raises(InvalidInput, match="a folder that is there"):
        identity.adopt(settings, store)
    assert not settings.data.exists()


# --- while the service runs ------------------------------------------------------------------------


def test_directory_away__nobody_leads_until_it_is_back(harness: Harness, tmp_path: Path) -> None:
    harness.store.create_sweep(sweep_of(3))
    one, other = harness.turn()
    harness.settings.data.rename(tmp_path / "away")
    harness.end_badly(one, Cause.ERROR, reason="No such file or directory")
    assert harness.turn() == []
    assert not harness.dispatcher.leads()
    assert "is not there" in str(harness.dispatcher.trouble())
    assert not harness.settings.data.exists()

    (tmp_path / "away").rename(harness.settings.data)
    harness.end_badly(other, Cause.ERROR, reason="No such file or directory")
    assert len(harness.turn()) == 2
    assert (harness.dispatcher.leads(), harness.dispatcher.trouble()) == (True, None)
    assert {harness.run(number).state for number in range(3)} == {State.RUNNING, State.QUEUED}
    assert (harness.engine.closed, harness.run().crashes) == ([], 0)


def test_another_directory__in_its_place_gets_no_work(harness: Harness, tmp_path: Path) -> None:
    harness.store.create_sweep(sweep_of(1))
    harness.settings.data.rename(tmp_path / "away")
    harness.settings.data.mkdir()
    assert harness.turn() == []
    assert "has no id" in str(harness.dispatcher.trouble())
    assert list(harness.settings.data.iterdir()) == []


def test_folder_of_an_attempt__is_not_made_where_the_directory_is_away(tmp_path: Path) -> None:
    artifacts = Artifacts(tmp_path / "data")
    with pytest.raises(FileNotFoundError):
        artifacts.make_folder(artifacts.run_folder(OTHER))
    assert not artifacts.root.exists()
    artifacts.root.mkdir()
    artifacts.make_folder(artifacts.run_folder(OTHER))
    assert artifacts.run_folder(OTHER).is_dir()


def test_retry__forgets_no_final_state_while_the_directory_is_away(tmp_path: Path) -> None:
    with open_api(tmp_path / "data", database_url=f"sqlite:///{tmp_path / 'x.db'}") as api:
        id = api.submit()
        for claim in api.store.claim(9, api.epoch()):
            state = replace(stored(STATE), path=f"runs/{STATE}")
            result = api.result(claim.id)
            api.store.finish(claim, replace(result, files=(*result.files, state)))
        api.compute()
        known = api.store.files()
        api.settings.data.rename(tmp_path / "away")
        answer = api.http.post(f"/v1/sweeps/{id}/retry")
        assert (answer.status_code, "is not there" in answer.json()["detail"]) == (503, True)
        assert api.store.files() == known
        assert sum(file.name == STATE for _, file in known) == 2
