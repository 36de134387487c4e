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

from service.api.app import build_app
from service.files.artifacts import Artifacts
from service.records.jobs import KeyRow, Scope, State, SweepState
from service.records.settings import Settings
from service.store import Store
from service.store.queries import now, tallies_of
from service.store.tables import JOBS
from tests.service.support.api import ADDRESS, FakeDispatcher
from tests.service.support.databases import Postgresql
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.rows import TERM, claim_runs, finish_all, result, statements

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
    key: KeyRow
    secret: str  # of the key
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
        for number in range(20, 20 + PARTS):
            part = store.create_sweep(sweep_of(runs_of(*["fine"] * PART, first=number * LARGE)))
        store.claim(LARGE // 5, TERM)
        others = (JOBS.c.id > run_id(9)) & (JOBS.c.id != run_id(10 * LARGE))
        with store._database.writing() as connection:
            ended = JOBS.update().where(JOBS.c.state == State.RUNNING, others)
            connection.execute(ended.values(state=State.SUCCEEDED))
            if not store._database.is_sqlite:  # PostgreSQL does it by itself, SQLite only when told
                connection.exec_driver_sql("ANALYZE")
        older = store.sweeps(limit=PARTS + 1).next_cursor
        assert older is not None
        sweeps = (large.id, part.id, small.id, cancelled, older)
        yield Filled(store, *sweeps, *store.create_key("anna", [Scope.READ]), said, of_large)


def _cancelled(store: Store) -> tuple[str, ...]:
    """Sweeps that were cancelled, and published as far as they were."""
    ids = []
    for number in range(5):
        runs = runs_of("fine", "fine", first=(50 + number) * LARGE)
        ids.append(store.create_sweep(sweep_of(runs)).id)
        [first] = claim_runs(store, 1)
        assert store.finish(first, result())
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
    "sweeps": lambda f: f.store.sweeps(cursor=f.older),
    "sweeps of a state": lambda f: f.store.sweeps(cursor=f.older, state=SweepState.CANCELLED),
    "sweeps with files": lambda f: f.store.front(cursor=f.older),
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
    with statements(_fresh(filled.store)) as sent:
        QUESTIONS[question](filled)
    assert len([one for one in sent if not one.startswith("BEGIN")]) <= PAGE


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
    """Statements that are sent while a page is answered by a service that has just begun.

    That a key was used is noted once a minute, beside the answers: not while this is looked at.
    """
    store = _fresh(filled.store)
    store._set(filled.key.id, used=now())
    _write_files(filled, Artifacts(folder))
    app = build_app(Settings(data=folder), store, FakeDispatcher())
    given = {"Authorization": f"Bearer {filled.secret}"} if with_key else {}
    with closing(app.state.live), statements(store) as sent:
        answer = TestClient(app, base_url=ADDRESS, headers=given).get(PAGES[page](filled))
    assert answer.status_code == 200, answer.text
    return len([one for one in sent if not one.startswith("BEGIN")])


def _fresh(store: Store) -> Store:
    """The store as it is when its service has just begun: no counts are remembered."""
    store._tallies._known.clear()
    return store


def _write_files(filled: Filled, artifacts: Artifacts) -> None:
    """The files that are sent as pages: runs and publications of this store left none."""
    files = [artifacts.path(filled.store.artifacts(filled.cancelled[0])[0])]
    for id, last in filled.store.known_attempts([run_id(7), run_id(ENDED)]).items():
        assert last.token is not None
        files.append(artifacts.log_of(id, last.attempt, last.token))
    for file in files:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(b"...")


@pytest.mark.parametrize("with_key", [False, True], ids=["without_key", "with_key"])
@pytest.mark.parametrize("page", PAGES)
def test_page__is_answered_with_at_most_three_statements(
    filled: Filled, page: str, with_key: bool, tmp_path: Path
) -> None:
    assert statements_for(filled, page, tmp_path, with_key=with_key) <= PAGE


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


@dataclass(frozen=True)
class Plan:
    """How a database says that it will answer a statement."""

    statement: str
    text: str


@contextmanager
def plans(store: Store) -> Iterator[list[Plan]]:
    """The plans of the statements that the block sends, asked for before each is executed."""
    told: list[Plan] = []
    words = "EXPLAIN QUERY PLAN" if store._database.is_sqlite else "EXPLAIN"

    def explain(_c: Any, cursor: Any, statement: str, parameters: Any, *_rest: Any) -> None:
        if not statement.startswith("BEGIN"):
            first = parameters[0] if isinstance(parameters, list) else parameters  # of many
            cursor.execute(f"{words} {statement}", first)
            told.append(Plan(statement, "\n".join(str(row[-1]) for row in cursor.fetchall())))

    engine = store._database._engine
    sa.event.listen(engine, "before_cursor_execute", explain)
    try:
        yield told
    finally:
        sa.event.remove(engine, "before_cursor_execute", explain)


LONG = ("jobs", "points", "events")  # tables with a row or more for each run
NAMES = {"publications": "jobs", "runs": "jobs"}  # that statements have for them


@dataclass(frozen=True)
class Whole:
    """What a statement reads from the first row to the last, and is right to."""

    statement: str  # words of it
    reads: frozenset[str]  # tables, by the names that the statement has for them
    only: Callable[[Filled], str] | None = None  # whose points alone it takes


def _whole(statement: str, *reads: str, only: Callable[[Filled], str] | None = None) -> Whole:
    return Whole(statement, frozenset(reads), only)


# The large sweep has most of the points and runs of the store: its own are found soonest among all.
OF_LARGE = _whole("AS point_state", "points", "jobs", only=lambda f: f.large)
# A publication for each sweep, and each has to be looked at for its state.
OF_A_STATE = _whole("AS revivals", "publications")
WHOLE: dict[str, Sequence[Whole]] = {
    "sweeps of a state": [OF_A_STATE],
    "sweeps, a large one too": [OF_LARGE],
    "sweep, the large one": [OF_LARGE],
    "queue": [_whole("FROM control", "jobs")],  # numbers about all jobs
    "tally": [_whole("AS bucket", "jobs")],
    "last event": [_whole("max(events.number)", "events")],  # the first row from behind
}


@pytest.mark.parametrize("question", QUESTIONS)
def test_question__is_read_through_an_index(filled: Filled, question: str) -> None:
    assert whole_tables_of(filled, question) == []


def whole_tables_of(filled: Filled, question: str) -> list[str]:
    """Lines of the plans of a question that read every row, although it is about some."""
    _fresh(filled.store)
    with plans(filled.store) as told:
        QUESTIONS[question](filled)
    right = WHOLE.get(question, ())
    return [
        read.line
        for plan in told
        for read in whole_reads(plan.text)
        if not any(_is_right(one, filled, plan, read) for one in right)
    ]


def _is_right(whole: Whole, filled: Filled, plan: Plan, read: "Read") -> bool:
    """Whether a table is read whole where that is right."""
    is_own = whole.only is None or read.name != "points" or whole.only(filled) in read.after
    return whole.statement in plan.statement and read.name in whole.reads and is_own


@pytest.mark.parametrize("question", ["sweep", "points", "counts", "sweeps with files"])
def test_question__without_its_index_is_seen(filled: Filled, question: str) -> None:
    """The check itself: what is read whole in vain does not pass for what may be."""
    plan = Plan("SELECT count(*) AS point_state", "Seq Scan on points  (cost=1)\n  Filter: (a)")
    [read] = whole_reads(plan.text)
    assert not any(_is_right(one, filled, plan, read) for one in WHOLE.get(question, ()))


def test_counts__of_the_large_sweep_may_read_no_other_points(filled: Filled) -> None:
    for id, is_right in ((filled.large, True), (filled.part, False)):
        text = f"Seq Scan on points  (cost=1)\n  Filter: ((sweep_id)::text = '{id}'::text)"
        plan = Plan("SELECT count(*) AS point_state", text)
        [read] = whole_reads(plan.text)
        assert _is_right(OF_LARGE, filled, plan, read) is is_right


def test_claim__is_read_through_its_index_in_its_order(filled: Filled) -> None:
    with plans(filled.store) as told:
        claims = filled.store.claim(2, TERM)
    assert len(claims) == 2
    [take] = [plan.text for plan in told if "jobs_queue" in plan.text]
    assert "TEMP B-TREE" not in take
    assert "Sort Key: jobs" not in take
    assert not whole_reads(take)


def test_finish__reads_a_few_rows_however_long_its_sweep(filled: Filled) -> None:
    [claim] = filled.store.claim(1, TERM)
    with plans(filled.store) as told:
        assert filled.store.finish(claim, result())
    assert [read for plan in told for read in whole_reads(plan.text)] == []


@dataclass(frozen=True)
class Read:
    """A table, or an index of it, that is read from its first row to its last."""

    name: str  # that the statement has for it
    line: str  # of the plan
    after: str  # the line behind: what is kept of the rows


# How the two databases say that they read a table, or an index of it; SQLite says SEARCH where it does not.
SCAN = re.compile(
    r"(?:SCAN |(?:Seq Scan|Index (?:Only )?Scan (?:Backward )?using \S+) on (?:\w+ (?=\w))?)(\w+)",
    re.ASCII,
)


def whole_reads(plan: str) -> list[Read]:
    """What a plan reads of the long tables that it reads whole."""
    lines = plan.splitlines()
    return [
        Read(name, line, after)
        for line, after in zip_longest(lines, lines[1:], fillvalue="")
        if (name := _scanned(line)) and "Index Cond" not in after
    ]


def _scanned(line: str) -> str | None:
    """The name of the long table that a line of a plan reads; a number behind it says nothing."""
    read = SCAN.search(line)
    name = re.sub(r"_\d+$", "", read[1]) if read else ""
    return name if NAMES.get(name, name) in LONG else None


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
        ("SCAN publications", True),
        ("->  Seq Scan on jobs publications  (cost=0.00..493.04)\n  Filter: (a)", True),
        ("->  Seq Scan on jobs jobs_1  (cost=0.00..493.04)\n  Filter: (a)", True),
    ],
)
def test_plan__that_reads_every_row_is_seen(plan: str, is_whole: bool) -> None:
    assert bool(whole_reads(plan)) is is_whole
