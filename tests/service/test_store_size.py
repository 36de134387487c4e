"""A sweep of 10 000 runs: statements are counted, and plans read, on both databases."""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
from fastapi.testclient import TestClient

from service.app import build_app
from service.jobs import State, SweepState
from service.settings import Settings
from service.store import Store
from service.store.queries import tallies_of
from service.store.tables import JOBS
from tests.service.api import ADDRESS, NoEngine
from tests.service.by_hand import EPOCH, finish_all, result, statements
from tests.service.databases import Postgresql
from tests.service.doubles import run_id, runs_of, sweep_of

LARGE, PART = 10_000, 100  # runs
PAGE = 3  # statements, whatever the size


@dataclass(frozen=True)
class Filled:
    """A store with a large sweep, some that are a part of it and a small one, and what it took to accept them."""

    store: Store
    large: str
    part: str
    small: str
    cancelled: tuple[str, ...]
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
    with filling(request.getfixturevalue(request.param)) as store:
        yield store


@contextmanager
def filling(url: str) -> Iterator[Filled]:
    """A store in which much has happened: no sweep has most of the rows, and few runs are under way."""
    with closing(Store.open(url, cost=lambda run: 1.0)) as store:
        cancelled = _cancelled(store)
        with statements(store) as few:
            small = store.create_sweep(sweep_of(runs_of("fine", first=10 * LARGE)))
        commits: list[None] = []
        sa.event.listen(store._database._engine, "commit", lambda _connection: commits.append(None))
        with statements(store) as many:
            large = store.create_sweep(sweep_of(LARGE))
        said = {"small": len(few), "large": len(many)}
        of_large = len(commits)
        for number in range(20, 28):
            part = store.create_sweep(sweep_of(runs_of(*["fine"] * PART, first=number * LARGE)))
        store.claim(LARGE // 5, EPOCH)
        others = (JOBS.c.id > run_id(9)) & (JOBS.c.id != run_id(10 * LARGE))
        with store._database.writing() as connection:
            ended = JOBS.update().where(JOBS.c.state == State.RUNNING, others)
            connection.execute(ended.values(state=State.SUCCEEDED))
            if not store._database.is_sqlite:  # PostgreSQL does it by itself, SQLite only when told
                connection.exec_driver_sql("ANALYZE")
        yield Filled(store, large.id, part.id, small.id, cancelled, said, of_large)


def _cancelled(store: Store) -> tuple[str, ...]:
    """Sweeps that were cancelled, and published as far as they were."""
    ids = []
    for number in range(5):
        runs = runs_of("fine", "fine", first=(50 + number) * LARGE)
        ids.append(store.create_sweep(sweep_of(runs)).id)
        store.cancel_sweep(ids[-1])
    finish_all(store)
    assert {store.sweep(id).state for id in ids} == {SweepState.CANCELLED}
    return tuple(ids)


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


def _counts(filled: Filled) -> object:
    """What a page of sweeps says of the points of one."""
    with filled.store._database.reading() as connection:
        return tallies_of(connection, [filled.part])


Ask = Callable[[Filled], object]
QUESTIONS: dict[str, Ask] = {
    "sweeps": lambda f: f.store.sweeps(),
    "sweeps of a state": lambda f: f.store.sweeps(state=SweepState.QUEUED),
    "sweep": lambda f: f.store.sweep(f.large),
    "counts": _counts,
    "document": lambda f: f.store.sweep_document(f.part),
    "bulletin": lambda f: f.store.bulletin(f.cancelled),
    "points": lambda f: f.store.sweep_runs(f.part),
    "points of a state": lambda f: f.store.sweep_runs(f.part, state=State.QUEUED),
    "run": lambda f: f.store.run(run_id(7)),
    "question of a run": lambda f: f.store.run_spec(run_id(7)),
    "files of a run": lambda f: f.store.run_files(run_id(7)),
    "events": lambda f: f.store.events(f.part),
    "events of a run": lambda f: f.store.run_events(run_id(7)),
    "everything that happened": lambda f: f.store.all_events(),
    "news": lambda f: f.store.news(after=LARGE // 10, limit=100),
    "last event": lambda f: f.store.last_event(),
    "runs under way": lambda f: f.store.under_way(),
    "queue": lambda f: f.store.queue(),
    "tally": lambda f: f.store.tally((1.0, 10.0, 100.0)),
    "artifacts": lambda f: f.store.artifacts(f.part),
}


@pytest.mark.parametrize("question", QUESTIONS)
def test_question__takes_at_most_three_statements(filled: Filled, question: str) -> None:
    with statements(filled.store) as sent:
        QUESTIONS[question](filled)
    assert len([one for one in sent if not one.startswith("BEGIN")]) <= PAGE


PAGES: dict[str, Callable[[Filled], str]] = {
    "sweeps, for people": lambda f: "/",
    "sweeps": lambda f: "/v1/sweeps",
    "sweeps of a state": lambda f: "/v1/sweeps?state=queued",
    "sweep": lambda f: f"/v1/sweeps/{f.large}",
    "document": lambda f: f"/v1/sweeps/{f.large}/document",
    "points": lambda f: f"/v1/sweeps/{f.large}/runs",
    "points of a state": lambda f: f"/v1/sweeps/{f.large}/runs?state=queued",
    "events": lambda f: f"/v1/sweeps/{f.large}/history",
    "cube": lambda f: f"/v1/sweeps/{f.cancelled[0]}/cube.nc",
    "run": lambda f: f"/v1/runs/{run_id(7)}",
    "files of a run": lambda f: f"/v1/runs/{run_id(7)}/files",
    "log of a run": lambda f: f"/v1/runs/{run_id(7)}/log",
    "events of a run": lambda f: f"/v1/runs/{run_id(7)}/history",
    "queue": lambda f: "/v1/queue",
}


def statements_for(filled: Filled, page: str, folder: Path) -> int:
    """Statements that are sent while a page is answered."""
    app = build_app(Settings(data=folder), filled.store, NoEngine())
    with closing(app.state.slices), closing(app.state.live), statements(filled.store) as sent:
        answer = TestClient(app, base_url=ADDRESS).get(PAGES[page](filled))
    assert answer.status_code in (200, 404), answer.text  # files of these runs are nowhere
    return len([one for one in sent if not one.startswith("BEGIN")])


@pytest.mark.parametrize("page", PAGES)
def test_page__is_answered_with_at_most_three_statements(
    filled: Filled, page: str, tmp_path: Path
) -> None:
    assert statements_for(filled, page, tmp_path) <= PAGE


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


LONG = ("jobs", "points", "events")  # tables with a row or more for each run
# Numbers about all rows read all of them. Whether a sweep has begun is known at the first run that has, the last
# event is the first row from behind.
WHOLE = {
    "sweeps": LONG,
    "sweeps of a state": LONG,
    "sweep": LONG,
    "queue": ("jobs",),
    "tally": ("jobs",),
    "last event": ("events",),
}


@pytest.mark.parametrize("question", QUESTIONS)
def test_question__is_read_through_an_index(filled: Filled, question: str) -> None:
    assert whole_tables_of(filled, question) == []


def whole_tables_of(filled: Filled, question: str) -> list[str]:
    """Lines of the plans of a question that read every row, although it is about some."""
    with plans(filled.store) as told:
        QUESTIONS[question](filled)
    tables = [table for table in LONG if table not in WHOLE.get(question, ())]
    return [line for plan in told for line in whole_tables(plan, tables)]


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


# How the two databases say that they read a table, or an index of it; SQLite says SEARCH where it does not.
SCAN = re.compile(
    r"(?:SCAN|Seq Scan on|Index (?:Only )?Scan (?:Backward )?using \S+ on) (\w+)", re.ASCII
)


def whole_tables(plan: str, tables: Sequence[str]) -> list[str]:
    """Lines of a plan that read one of these tables, or an index of it, from its first row to its last."""
    lines = plan.splitlines()
    return [
        line
        for line, after in zip_longest(lines, lines[1:], fillvalue="")
        if (read := SCAN.search(line)) and read[1] in tables and "Index Cond" not in after
    ]


@pytest.mark.parametrize(
    ("plan", "is_whole"),
    [
        ("SCAN jobs", True),
        ("SCAN jobs USING COVERING INDEX jobs_queue", True),
        ("SEARCH jobs USING INDEX jobs_queue (state=?)", False),
        ("->  Seq Scan on jobs  (cost=0.00..493.04)\n  Filter: (a)", True),
        ("->  Index Scan using jobs_pkey on jobs  (cost=0.29)\n  Filter: (a)", True),
        ("->  Index Only Scan Backward using jobs_pkey on jobs  (cost=0.29)", True),
        ("->  Index Scan using jobs_pkey on jobs runs  (cost=0.29)\n  Index Cond: (a)", False),
        (
            "Bitmap Heap Scan on jobs\n  ->  Bitmap Index Scan on jobs_queue\n  Index Cond: (a)",
            False,
        ),
        ("SCAN sweeps", False),
    ],
)
def test_plan__that_reads_every_row_is_seen(plan: str, is_whole: bool) -> None:
    assert bool(whole_tables(plan, LONG)) is is_whole
