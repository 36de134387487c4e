"""A sweep of 10 000 runs: statements are counted, and plans read, on both databases."""

from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from service.jobs import State, SweepState
from service.store import Store
from tests.service.by_hand import EPOCH, result, statements
from tests.service.databases import Postgresql
from tests.service.doubles import run_id, runs_of, sweep_of

LARGE = 10_000
PAGE = 3  # statements, whatever the size


@dataclass(frozen=True)
class Filled:
    """A store with a large sweep and a small one, and what it took to accept them."""

    store: Store
    large: str
    small: str
    said: dict[str, int]  # statements to accept each
    commits: int  # of the large one


@pytest.fixture(scope="module")
def sqlite_file(tmp_path_factory: pytest.TempPathFactory) -> str:
    folder: Path = tmp_path_factory.mktemp("large")
    return f"sqlite:///{folder / 'whipple.db'}"


@pytest.fixture(scope="module")
def postgresql_database(postgresql: Postgresql) -> Iterator[str]:
    with postgresql.database() as url:
        yield url


@pytest.fixture(scope="module", params=["sqlite_file", "postgresql_database"])
def filled(request: pytest.FixtureRequest) -> Iterator[Filled]:
    url = request.getfixturevalue(request.param)
    with closing(Store.open(url, cost=lambda run: 1.0)) as store:
        with statements(store) as few:
            small = store.create_sweep(sweep_of(runs_of("fine", first=10 * LARGE)))
        commits: list[None] = []
        sa.event.listen(store._database._engine, "commit", lambda _connection: commits.append(None))
        with statements(store) as many:
            large = store.create_sweep(sweep_of(LARGE))
        said = {"small": len(few), "large": len(many)}
        of_large = len(commits)
        store.claim(LARGE // 5, EPOCH)  # something has happened
        with store._database.writing() as connection:
            connection.exec_driver_sql("ANALYZE")
        yield Filled(store, large.id, small.id, said, of_large)


# --- statements ------------------------------------------------------------------------------------


def test_accept__is_one_transaction_of_as_many_statements_as_for_one_run(filled: Filled) -> None:
    assert filled.said["large"] == filled.said["small"]
    assert filled.commits == 1


def test_accept__joining_takes_a_few_more_whatever_the_size(store: Store) -> None:
    said = []
    for number in (1, 1000):
        store.create_sweep(sweep_of(number))
        with statements(store) as sent:
            joined = store.create_sweep(sweep_of(number))
        assert (joined.new, joined.reused) == (0, number)
        said.append(len(sent))
    assert said[0] == said[1]


Ask = Callable[[Filled], object]
QUESTIONS: dict[str, Ask] = {
    "sweeps": lambda f: f.store.sweeps(),
    "sweeps of a state": lambda f: f.store.sweeps(state=SweepState.QUEUED),
    "sweep": lambda f: f.store.sweep(f.large),
    "points": lambda f: f.store.sweep_runs(f.large),
    "points of a state": lambda f: f.store.sweep_runs(f.large, state=State.QUEUED),
    "run": lambda f: f.store.run(run_id(7)),
    "events": lambda f: f.store.events(f.large),
    "events of a run": lambda f: f.store.run_events(run_id(7)),
    "everything that happened": lambda f: f.store.all_events(),
    "runs under way": lambda f: f.store.under_way(),
    "queue": lambda f: f.store.queue(),
    "tally": lambda f: f.store.tally((1.0, 10.0, 100.0)),
    "artifacts": lambda f: f.store.artifacts(f.large),
}


@pytest.mark.parametrize("question", QUESTIONS)
def test_page__takes_at_most_three_statements(filled: Filled, question: str) -> None:
    with statements(filled.store) as sent:
        QUESTIONS[question](filled)
    assert len([one for one in sent if not one.startswith("BEGIN")]) <= PAGE


def test_orders__take_as_many_statements_for_many_runs_as_for_one(filled: Filled) -> None:
    orders: dict[str, Callable[[str], object]] = {
        "priority": lambda id: filled.store.set_priority(id, 3),
        "cancel": filled.store.cancel_sweep,
        "retry": filled.store.retry_sweep,
    }
    for name, order in orders.items():
        with statements(filled.store) as few:
            order(filled.small)
        with statements(filled.store) as many:
            order(filled.large)
        assert len(many) == len(few), name


# --- plans -----------------------------------------------------------------------------------------


@contextmanager
def plans(store: Store) -> Iterator[list[str]]:
    """The plans of the statements that the block sends, asked for before each is executed."""
    told: list[str] = []
    words = "EXPLAIN QUERY PLAN" if store._database.is_sqlite else "EXPLAIN"

    def explain(_c: Any, cursor: Any, statement: str, parameters: Any, *_rest: Any) -> None:
        if not statement.startswith("BEGIN"):
            first = parameters[0] if isinstance(parameters, list) else parameters  # of many
            cursor.execute(f"{words} {statement}", first)
            told.append("\n".join(str(row[-1]) for row in cursor.fetchall()))

    engine = store._database._engine
    sa.event.listen(engine, "before_cursor_execute", explain)
    try:
        yield told
    finally:
        sa.event.remove(engine, "before_cursor_execute", explain)


# Tables of which a question reads a part. (The points of the large sweep are nearly all there are.)
PARTS = {
    "points": ("jobs", "points", "events"),
    "run": ("jobs", "points", "events"),
    "artifacts": ("jobs", "points", "events"),
    "events of a run": ("jobs", "points", "events"),
    "everything that happened": ("jobs", "points", "events"),
    "events": ("jobs", "events"),
}


@pytest.mark.parametrize("question", PARTS)
def test_page__is_read_through_an_index(filled: Filled, question: str) -> None:
    with plans(filled.store) as told:
        QUESTIONS[question](filled)
    for plan in told:
        assert not whole_tables(plan, PARTS[question]), plan


def test_claim__is_read_through_its_index_in_its_order(filled: Filled) -> None:
    with plans(filled.store) as told:
        claims = filled.store.claim(2, EPOCH)
    assert len(claims) == 2
    [take] = [plan for plan in told if "jobs_queue" in plan]
    assert "TEMP B-TREE" not in take
    assert "Sort Key: jobs" not in take
    assert not whole_tables(take, ("jobs",)), take


def test_finish__reads_a_few_rows_however_long_its_sweep(filled: Filled) -> None:
    [claim] = filled.store.claim(1, EPOCH)
    with plans(filled.store) as told:
        assert filled.store.finish(claim, result())
    for plan in told:
        assert not whole_tables(plan, ("jobs", "points", "events")), plan


def whole_tables(plan: str, tables: tuple[str, ...]) -> list[str]:
    """Lines of a plan that read one of these tables from its first row to its last."""
    scans = [f"SCAN {table}" for table in tables] + [f"Seq Scan on {table}" for table in tables]
    return [
        line
        for line in plan.splitlines()
        if any(scan in line for scan in scans) and "USING" not in line
    ]
