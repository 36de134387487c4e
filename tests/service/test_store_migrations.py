"""Tables of an older store are brought up to date, and what was accepted in it is still there."""

import os
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext

from service.artifacts import Artifacts
from service.care import Care
from service.jobs import (
    ANSWER,
    STATE,
    Cause,
    Keep,
    Kind,
    NotFound,
    State,
    StoreUnavailable,
    SweepState,
)
from service.space import Space
from service.store import Store
from service.store.connection import Database
from service.store.tables import JOBS, TABLES
from tests.service.by_hand import finish_all, result
from tests.service.databases import Postgresql
from tests.service.doubles import run_id, runs_of, settings_in, sweep_of

OLD_STORES = Path(__file__).parent / "old_stores"
FILES = ["cube.nc", "report.html", "report.json"]


@pytest.fixture
def old_sqlite(tmp_path: Path) -> str:
    file = tmp_path / "old.db"
    with closing(sqlite3.connect(file)) as connection:
        connection.executescript((OLD_STORES / "schema_0001.sqlite.sql").read_text())
    return f"sqlite:///{file}"


@pytest.fixture
def old_postgresql(postgresql: Postgresql) -> Iterator[str]:
    with postgresql.database(like="template0") as url:
        database = Database(url)
        with database._engine.begin() as connection:
            text = (OLD_STORES / "schema_0001.postgresql.sql").read_text()
            connection.connection.cursor().execute(text)
        database.close()
        yield url


@pytest.fixture(params=["old_sqlite", "old_postgresql"])
def old_url(request: pytest.FixtureRequest) -> str:
    """A store of the first schema: sweeps that are done, cancelled, under way and new."""
    return request.getfixturevalue(request.param)


@pytest.fixture
def upgraded(old_url: str) -> Iterator[Store]:
    with closing(Store.open(old_url, cost=lambda run: 1.0)) as opened:
        yield opened


def by_name(store: Store) -> dict[str, Any]:
    return {row.name: row for row in store.sweeps().items}


def test_schema__is_told_before_and_after(old_url: str) -> None:
    seen = Store.schema(old_url)
    assert (seen.found, seen.newest) == ("0001", "0004")
    Store.open(old_url).close()
    assert Store.schema(old_url).found == "0004"


def test_schema__of_an_empty_database_is_none(tmp_path: Path) -> None:
    assert Store.schema(f"sqlite:///{tmp_path / 'new.db'}").found is None


def test_upgrade__sweeps_and_their_states_stay(upgraded: Store) -> None:
    seen = by_name(upgraded)
    assert {name: row.state for name, row in seen.items()} == {
        "done": SweepState.SUCCEEDED,
        "cancelled": SweepState.CANCELLED,
        "unpublishable": SweepState.FAILED,
        "under way": SweepState.RUNNING,
        "joined": SweepState.RUNNING,
        "two-speeds": SweepState.QUEUED,
    }
    for row in seen.values():
        assert (row.owner, row.priority, row.keep) == ("", 0, Keep.FINAL)
    assert seen["done"].counts["failed"] == 2
    assert upgraded.sweep_document(seen["two-speeds"].id)["scenario"] == "thin_plate"
    kinds = [event.kind for event in upgraded.events(seen["done"].id)]
    assert (kinds[0], kinds[-1]) == ("accepted", "published")


def test_upgrade__files_belong_to_jobs(upgraded: Store) -> None:
    done = by_name(upgraded)["done"]
    files = upgraded.artifacts(done.id)
    assert [file.name for file in files] == FILES
    assert files[0].path == f"sweeps/{done.id}/1-abcdef01/cube.nc"
    assert files[0].size == 3
    run = upgraded.run(run_id(0))
    answer = upgraded.run_file(run.id, ANSWER)
    assert (answer.path, answer.sha256) == (run.path, run.sha256)


def test_upgrade__runs_keep_what_was_known_of_them(upgraded: Store) -> None:
    verdict, accident, crashed = (upgraded.run(run_id(number)) for number in (1, 2, 31))
    assert (verdict.cause, verdict.state) == (Cause.VERDICT, State.FAILED)
    assert (accident.cause, accident.reason) == (Cause.CRASH, "died")
    assert (crashed.crashes, crashed.state) == (1, State.QUEUED)
    assert crashed.checkpoint is None
    assert upgraded.pace() == 2.0


def test_upgrade__final_states_stay_though_no_row_names_them(
    upgraded: Store, tmp_path: Path
) -> None:
    settings = settings_in(tmp_path / "data", disk_reserve=0)
    artifacts, [succeeded] = Artifacts(settings.data), upgraded.known_attempts([run_id(0)]).values()
    assert succeeded.token is not None
    folder = artifacts.log_of(run_id(0), succeeded.attempt, succeeded.token).parent
    folder.mkdir(parents=True)
    for name in (ANSWER, STATE, "film.npz"):
        (folder / name).write_text("x")
        os.utime(folder / name, (0, 0))
    os.utime(folder, (0, 0))
    care = Care(settings, upgraded, artifacts, Space(settings.data, 0))
    for _ in range(4):
        care.step()
    assert {file.name for file in folder.iterdir()} == {ANSWER, STATE}  # no sweep keeps the film


def test_upgrade__the_queue_goes_on_in_turn(upgraded: Store) -> None:
    [held] = upgraded.claimed()
    epoch = upgraded.begin_epoch("new")
    adopted = upgraded.adopt(held, epoch)
    assert adopted is not None
    assert upgraded.finish(adopted, result())
    claims = [upgraded.claim(1, epoch)[0] for _ in range(4)]
    assert {claim.id for claim in claims[:2]} & {run_id(31), run_id(32)}  # each sweep has its share
    for claim in claims:
        assert (claim.kind, claim.priority) == (Kind.RUN, 0)
        assert upgraded.finish(claim, result())
    publications = upgraded.claim(9, epoch)
    assert [(one.kind, one.priority) for one in publications] == [(Kind.PUBLISH, -1000)] * 3


def test_upgrade__runs_of_nobody_are_let_go_of_that_day(old_url: str) -> None:
    database = Database(old_url)
    with database._engine.begin() as connection:
        connection.exec_driver_sql(f"DELETE FROM points WHERE run_id = '{run_id(0)}'")
    database.close()
    with closing(Store.open(old_url)) as store:
        assert store.forget_runs(datetime.now(UTC) - timedelta(days=1), 9) == 0
        assert store.forget_runs(datetime.now(UTC) + timedelta(days=1), 9) == 1
        with pytest.raises(NotFound):
            store.run(run_id(0))


def test_upgrade__what_was_computed_is_not_computed_again(upgraded: Store) -> None:
    row = upgraded.create_sweep(sweep_of([*runs_of("fine"), *runs_of("fine", first=10)]))
    assert (row.reused, row.new) == (2, 0)


def test_upgrade__everything_that_was_accepted_can_be_finished(upgraded: Store) -> None:
    for claim in upgraded.claimed():
        upgraded.requeue(claim, Cause.LOST, reason="the service was gone")
    epoch = upgraded.begin_epoch("new")
    finish_all(upgraded, epoch=epoch)
    assert all(row.is_terminal for row in upgraded.sweeps().items)
    for row in upgraded.sweeps().items:
        upgraded.delete_sweep(row.id)
    assert upgraded.claim(9, epoch) == ()


@pytest.mark.parametrize("url", ["sqlite_url", "postgresql_url", "old_sqlite", "old_postgresql"])
def test_tables__are_those_that_the_queries_expect(
    request: pytest.FixtureRequest, url: str
) -> None:
    with (
        closing(Store.open(request.getfixturevalue(url))) as store,
        store._database.reading() as reading,
    ):
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


def test_tables__of_a_younger_service_are_left_alone(database_url: str) -> None:
    with closing(Store.open(database_url)) as store, store._database.writing() as writing:
        writing.exec_driver_sql("UPDATE alembic_version SET version_num = '9999'")
    with pytest.raises(StoreUnavailable, match="9999"):
        Store.open(database_url)
