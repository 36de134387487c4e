"""The id that data directory and database share, and what is done where they have two."""

from dataclasses import replace
from pathlib import Path

import pytest

from service.files.stores import IDENTITY
from service.queue import data_identity as identity
from service.queue.data_identity import WrongDirectory
from service.records.jobs import Submission
from service.settings import Settings
from service.store import Store
from studies.quantities.files import STATE
from tests.service.support.api import open_api
from tests.service.support.fakes import settings_in, stored, sweep_of
from tests.service.support.rows import finish_all

OTHER = "0123456789abcdef" * 2


@pytest.fixture
def settings(tmp_path: Path, database_url: str) -> Settings:
    return settings_in(tmp_path / "data", database_url=database_url)


def test_settle__gives_both_one_id_that_stays(settings: Settings, store: Store) -> None:
    identity.settle(settings, store)
    first = store.data_id()
    assert first is not None
    assert identity.read(settings.data) == first
    identity.settle(settings, store)
    assert identity.read(settings.data) == store.data_id() == first


def test_settle__refuses_an_empty_directory_for_results_of_a_store_without_id(settings: Settings, store: Store) -> None:
    store.sweeps.create(Submission(sweep_of(1)))
    finish_all(store)
    settings.data.mkdir()
    with pytest.raises(WrongDirectory, match=r"no results.*mount it, or .*whipple doctor --adopt"):
        identity.settle(settings, store)
    assert store.data_id() is None
    assert list(settings.data.iterdir()) == []
    identity.adopt(settings, store)
    identity.settle(settings, store)


@pytest.mark.parametrize(("in_directory", "in_database"), [(None, True), (OTHER, False), (OTHER, True)])
def test_settle__refuses_two_ids_until_the_directory_is_adopted(
    settings: Settings, store: Store, in_directory: str | None, in_database: bool
) -> None:
    """An empty directory, an empty database, and the directory of another database."""
    settings.data.mkdir()
    if in_database:
        identity.settle(settings, store)
        (settings.data / IDENTITY).unlink()
    if in_directory:
        identity.write(settings.data, in_directory)
    before = store.data_id()
    has = f"the id {in_directory}" if in_directory else "has no id"
    database_has = f"the id {before}" if before else "no id"
    with pytest.raises(WrongDirectory, match=f"{has}.*{database_has}.*whipple doctor --adopt"):
        identity.settle(settings, store)
    assert store.data_id() == before
    adopted = identity.adopt(settings, store)
    assert adopted == (before or in_directory) == identity.read(settings.data) == store.data_id()
    identity.settle(settings, store)


def test_retry__forgets_no_final_state_while_the_directory_is_away(tmp_path: Path) -> None:
    with open_api(tmp_path / "data", database_url=f"sqlite:///{tmp_path / 'x.db'}") as api:
        id = api.submit()
        for claim in api.store.leases.take(9, api.term()):
            state = replace(stored(STATE), path=f"runs/{STATE}")
            result = api.result(claim.id)
            api.store.leases.finish(claim, replace(result, files=(*result.files, state)))
        api.compute()
        files = api.store.retention.files()
        api.settings.data.rename(tmp_path / "away")
        answer = api.http.post(f"/v1/sweeps/{id}/retry")
        assert (answer.status_code, "is missing" in answer.json()["detail"]) == (503, True)
        assert api.store.retention.files() == files
        assert sum(file.name == STATE for _, file in files) == 2
