"""A sweep of 10 000 runs: statements are counted, and plans read, on both databases."""

import math
import re
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
from fastapi.testclient import TestClient

from service.api.app import build_app
from service.files.artifacts import Artifacts
from service.records.jobs import Scope, State, Submission, SweepState
from service.records.settings import Settings
from service.store import Store
from service.store.commands import BATCH
from service.store.statements import now
from service.store.sweep_queries import tallies_of
from service.store.tables import JOBS, KEYS
from tests.service.support.api import ADDRESS, FakeDispatcher
from tests.service.support.databases import Postgresql
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.rows import TERM, finish_all, lease_runs, result, statements

LARGE, PART = 10_000, 100  # runs
PARTS = 8  # sweeps of so many
PAGE = 3  # statements, whatever the size


@dataclass(frozen=True)
class Filled:
    """A store with a large sweep, some that are a part of it and a small one, and what it took to accept them."""

    store: Store
    large: str
    part: str
    small: str
    cancelled: tuple[str, ...]
    older: str  # cursor of a page without the large sweep and what is younger
    secret: str  # of a key
    accepting: dict[str, int]  # statements to accept each
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
            small = store.create_sweep(Submission(sweep_of(runs_of("fine", first=10 * LARGE))))
        commits: list[None] = []
        sa.event.listen(store._database._engine, "commit", lambda _connection: commits.append(None))
        with statements(store) as many:
            large = store.create_sweep(Submission(sweep_of(LARGE)))
        accepting = {"small": len(few), "large": len(many)}
        of_large = len(commits)
        for number in range(20, 20 + PARTS):
            part = store.create_sweep(Submission(sweep_of(runs_of(*["fine"] * PART, first=number * LARGE))))
        store.lease(LARGE // 5, TERM)
        others = (JOBS.c.id > run_id(9)) & (JOBS.c.id != run_id(10 * LARGE))
        with store._database.writing() as connection:
            ended = JOBS.update().where(JOBS.c.state == State.RUNNING, others)
            connection.execute(ended.values(state=State.SUCCEEDED))
            if not store._database.is_sqlite:  # PostgreSQL does it by itself, SQLite only when told
                connection.exec_driver_sql("ANALYZE")
        older = store.sweeps(limit=PARTS + 1).next_cursor
        assert older is not None
        sweeps = (large.id, part.id, small.id, cancelled, older)
        yield Filled(store, *sweeps, store.create_key("anna", [Scope.READ])[1], accepting, of_large)


def _cancelled(store: Store) -> tuple[str, ...]:
    """Sweeps that were cancelled, and published as far as they were."""
    ids = []
    for number in range(5):
        runs = runs_of("fine", "fine", first=(50 + number) * LARGE)
        ids.append(store.create_sweep(Submission(sweep_of(runs))).id)
        [first] = lease_runs(store, 1)
        assert store.finish(first, result())
        store.cancel_sweep(ids[-1])
        finish_all(store)
    assert {store.sweep(id).state for id in ids} == {SweepState.CANCELLED}
    return tuple(ids)


# --- statements ------------------------------------------------------------------------------------


def test_accept__is_one_transaction_of_two_statements_more_for_each_thousand_runs(filled: Filled) -> None:
    assert filled.accepting["large"] == filled.accepting["small"] + 2 * ((LARGE - 1) // BATCH)
    assert filled.commits == 1


def test_accept__joining_takes_a_few_more_whatever_the_size(store: Store) -> None:
    counted = []
    for number in (1, 1000):
        store.create_sweep(Submission(sweep_of(number)))
        with statements(store) as sent:
            joined = store.create_sweep(Submission(sweep_of(number)))
        assert (joined.new, joined.reused) == (0, number)
        counted.append(len(sent))
    assert counted[0] == counted[1]


def _counts(filled: Filled) -> object:
    """The tally of one sweep of a page."""
    with filled.store._database.reading() as connection:
        return tallies_of(connection, [filled.part])


Query = Callable[[Filled], object]
QUERIES: dict[str, Query] = {
    "sweeps": lambda f: f.store.sweeps(cursor=f.older),
    "sweeps of a state": lambda f: f.store.sweeps(cursor=f.older, state=SweepState.CANCELLED),
    "sweeps with files": lambda f: f.store.sweeps_with_files(cursor=f.older),
    "sweeps, a large one too": lambda f: f.store.sweeps(),
    "sweep": lambda f: f.store.sweep(f.part),
    "sweep with files": lambda f: f.store.sweep_and_files(f.part),
    "sweep with a file": lambda f: f.store.sweep_and_file(f.part, "cube.nc"),
    "sweep, the large one": lambda f: f.store.sweep(f.large),
    "counts": _counts,
    "document": lambda f: f.store.sweep_document(f.part),
    "points": lambda f: f.store.sweep_runs(f.part),
    "points of a state": lambda f: f.store.sweep_runs(f.part, state=State.QUEUED),
    "run": lambda f: f.store.run(run_id(7)),
    "spec of a run": lambda f: f.store.run_spec(run_id(7)),
    "files of a run": lambda f: f.store.run_files(run_id(7)),
    "events": lambda f: f.store.events(f.part),
    "events of a run": lambda f: f.store.run_events(run_id(7)),
    "all events": lambda f: f.store.all_events(),
    "last event": lambda f: f.store.last_event(),
    "runs under way": lambda f: f.store.under_way(),
    "queue": lambda f: f.store.queue(),
    "tally": lambda f: f.store.tally((1.0, 10.0, 100.0)),
    "artifacts": lambda f: f.store.artifacts(f.part),
}


@pytest.mark.parametrize("query", QUERIES)
def test_query__takes_at_most_three_statements(filled: Filled, query: str) -> None:
    with statements(_fresh(filled.store)) as sent:
        QUERIES[query](filled)
    assert len([text for text in sent if not text.startswith("BEGIN")]) <= PAGE


ENDED = 20  # number of a run that has a result, but no registered log
PAGES: dict[str, Callable[[Filled], str]] = {
    "sweeps, for people": lambda f: "/",
    "sweeps": lambda f: "/v1/sweeps",
    "sweeps of a state": lambda f: "/v1/sweeps?state=running",
    "sweep": lambda f: f"/v1/sweeps/{f.large}",
    "document": lambda f: f"/v1/sweeps/{f.large}/document",
    "points": lambda f: f"/v1/sweeps/{f.large}/runs",
    "points of a state": lambda f: f"/v1/sweeps/{f.large}/runs?state=queued",
    "events": lambda f: f"/v1/sweeps/{f.large}/history",
    "cube": lambda f: f"/v1/sweeps/{f.cancelled[0]}/cube.nc",
    "run": lambda f: f"/v1/runs/{run_id(7)}",
    "files of a run": lambda f: f"/v1/runs/{run_id(7)}/files",
    "log of a run": lambda f: f"/v1/runs/{run_id(7)}/log",
    "log of a run that has ended": lambda f: f"/v1/runs/{run_id(ENDED)}/log",
    "events of a run": lambda f: f"/v1/runs/{run_id(7)}/history",
    "queue": lambda f: "/v1/queue",
}


def statements_for(filled: Filled, page: str, folder: Path, *, with_key: bool) -> int:
    """Statements that a service that has just begun sends for a page.

    The use of the key was noted just before, so that it is not noted now.
    """
    store = _fresh(filled.store)
    with store._database.writing() as connection:
        connection.execute(KEYS.update().values(used=now()))
    _write_files(filled, Artifacts(folder))
    app = build_app(Settings(data=folder), store, FakeDispatcher())
    headers = {"Authorization": f"Bearer {filled.secret}"} if with_key else {}
    client = TestClient(app, base_url=ADDRESS, headers=headers)
    client.get("/readyz")  # whose outcome and counts the queue shares, here for good
    app.state.readiness._ended = math.inf
    store._counts = replace(store._counts, time=math.inf)
    with closing(app.state.event_streams), statements(store) as sent:
        response = client.get(PAGES[page](filled))
    assert response.status_code == 200, response.text
    return len([text for text in sent if not text.startswith("BEGIN")])


def _fresh(store: Store) -> Store:
    """The store of a service that has just begun: no tallies are remembered."""
    store._tallies._remembered.clear()
    return store


def _write_files(filled: Filled, artifacts: Artifacts) -> None:
    """The files that are sent as pages: runs and publications of this store left none."""
    files = [artifacts.path(filled.store.artifacts(filled.cancelled[0])[0])]
    for id, last in filled.store.last_attempts([run_id(7), run_id(ENDED)]).items():
        assert last.token is not None
        files.append(artifacts.log_of(id, last.attempt, last.token))
    for file in files:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(b"...")


@pytest.mark.parametrize("page", PAGES)
def test_page__takes_at_most_three_statements_with_the_check_of_the_key(
    filled: Filled, page: str, tmp_path: Path
) -> None:
    assert statements_for(filled, page, tmp_path, with_key=True) <= PAGE


def test_commands__take_as_many_statements_for_many_runs_as_for_one(filled: Filled) -> None:
    commands: dict[str, Callable[[str], object]] = {
        "priority": lambda id: filled.store.set_priority(id, 3),
        "cancel": filled.store.cancel_sweep,
        "retry": filled.store.retry_sweep,
    }
    for name, command in commands.items():
        with statements(filled.store) as few:
            command(filled.small)
        with statements(filled.store) as many:
            command(filled.large)
        assert len(many) == len(few), name


# --- plans -----------------------------------------------------------------------------------------


@contextmanager
def plans(store: Store) -> Iterator[list[str]]:
    """The plans of the statements that the block sends, read before each is executed."""
    texts: list[str] = []
    explain = "EXPLAIN QUERY PLAN" if store._database.is_sqlite else "EXPLAIN"

    def read(_c: Any, cursor: Any, statement: str, parameters: Any, *_rest: Any) -> None:
        if not statement.startswith("BEGIN"):
            first = parameters[0] if isinstance(parameters, list) else parameters  # of many
            cursor.execute(f"{explain} {statement}", first)
            texts.append("\n".join(str(row[-1]) for row in cursor.fetchall()))

    engine = store._database._engine
    sa.event.listen(engine, "before_cursor_execute", read)
    try:
        yield texts
    finally:
        sa.event.remove(engine, "before_cursor_execute", read)


LONG = ("jobs", "points", "events")  # tables with a row or more for each run
NAMES = {"publications": "jobs", "runs": "jobs"}  # that statements have for them


# Tables that a query reads from the first row to the last, and is right to.
WHOLE = {
    "sweeps of a state": {"publications"},  # each has to be looked at for its state
    "sweeps, a large one too": {"points", "jobs"},  # the large sweep has most of them
    "sweep, the large one": {"points", "jobs"},
    "queue": {"jobs", "events"},  # numbers about all jobs; the first event from behind
    "tally": {"jobs"},
    "last event": {"events"},  # the first row from behind
}


@pytest.mark.parametrize("query", QUERIES)
def test_query__is_read_through_an_index(filled: Filled, query: str) -> None:
    assert whole_tables_of(filled, query) == []


def whole_tables_of(filled: Filled, query: str) -> list[str]:
    """Lines of the plans of a query that read every row, although the query is about some."""
    _fresh(filled.store)
    with plans(filled.store) as asked:
        QUERIES[query](filled)
    reads = (read for plan in asked for read in whole_reads(plan))
    return [line for name, line in reads if name not in WHOLE.get(query, ())]


def test_lease__is_read_through_its_index_in_its_order(filled: Filled) -> None:
    with plans(filled.store) as texts:
        assert len(filled.store.lease(2, TERM)) == 2
    [plan] = [text for text in texts if "jobs_queue" in text]
    assert "TEMP B-TREE" not in plan
    assert "Sort Key: jobs" not in plan
    assert not whole_reads(plan)


def test_finish__reads_a_few_rows_however_long_its_sweep(filled: Filled) -> None:
    [lease] = filled.store.lease(1, TERM)
    with plans(filled.store) as texts:
        assert filled.store.finish(lease, result())
    assert [read for text in texts for read in whole_reads(text)] == []


# A line of a plan that reads a whole table, or a whole index of it; SQLite says SEARCH of a part.
SCAN = re.compile(
    r"(?:SCAN |(?:Seq Scan|Index (?:Only )?Scan (?:Backward )?using \S+) on (?:\w+ (?=\w))?)(\w+)", re.ASCII
)


def whole_reads(plan: str) -> list[tuple[str, str]]:
    """The long tables that a plan reads whole, each with the line of the plan."""
    lines = plan.splitlines()
    return [
        (name, line)
        for line, condition in zip_longest(lines, lines[1:], fillvalue="")
        if (name := _scanned(line)) and "Index Cond" not in condition
    ]


def _scanned(line: str) -> str | None:
    """The name of the long table that a line of a plan reads, without a number behind it."""
    read = SCAN.search(line)
    name = re.sub(r"_\d+$", "", read[1]) if read else ""
    return name if NAMES.get(name, name) in LONG else None


@pytest.mark.parametrize(
    ("plan", "is_whole"),
    [
        ("SCAN jobs USING COVERING INDEX jobs_queue", True),
        ("SEARCH jobs USING INDEX jobs_queue (state=?)", False),
        ("->  Index Only Scan Backward using jobs_pkey on jobs  (cost=0.29)", True),
        ("->  Index Scan using jobs_pkey on jobs runs  (cost=0.29)\n  Index Cond: (a)", False),
        ("SCAN sweeps", False),
        ("->  Seq Scan on jobs publications  (cost=0.00..493.04)\n  Filter: (a)", True),
        ("->  Seq Scan on jobs jobs_1  (cost=0.00..493.04)\n  Filter: (a)", True),
    ],
)
def test_plan__that_reads_every_row_is_seen(plan: str, is_whole: bool) -> None:
    assert bool(whole_reads(plan)) is is_whole
