"""A sweep of 10 000 runs: statements are counted, and plans read, on both databases."""

import math
import re
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from itertools import zip_longest
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa
from fastapi.testclient import TestClient

from service.api.app import build_app
from service.records.jobs import Scope, State, Submission, SweepState
from service.records.logbook import Wanted
from service.settings import Settings
from service.store import Store
from service.store.submission import BATCH
from service.store.tables import JOBS, KEYS, now
from service.store.time_left import tallies_of
from tests.service.support.api import ADDRESS, FakeDispatcher
from tests.service.support.fakes import run_id, runs_of, sweep_of
from tests.service.support.rows import TERM, finish_all, lease_runs, result, statements

LARGE, PART = 10_000, 100  # runs
PARTS = 8  # sweeps of so many
PAGE = 3  # statements, whatever the size
SAYS = (
    "10 000 runs: one transaction to accept, at most three statements a page, read through indices, cancel as for one"
)
pytestmark = pytest.mark.claim("queue", "size", says=SAYS)
WRITE = re.compile(r"(?:UPDATE|DELETE FROM|INSERT INTO) (\w+)")


@dataclass(frozen=True)
class Filled:
    """A store with a large sweep, some that are a part of it and a small one, and what it took to accept them."""

    store: Store
    large: str
    part: str
    small: str
    older: str  # cursor of a page without the large sweep and what is younger
    secret: str  # of a key
    accepting: dict[str, int]  # statements to accept each
    commits: int  # of the large one


@pytest.fixture(scope="module")
def filled(module_url: str) -> Iterator[Filled]:
    """A store in which much has happened: no sweep has most of the rows, and few runs are under way."""
    with closing(Store.open(module_url)) as store:
        _cancel(store)
        with statements(store) as few:
            small = store.sweeps.create(Submission(sweep_of(runs_of("fine", first=10 * LARGE))))
        commits: list[None] = []
        sa.event.listen(store.database._engine, "commit", lambda _connection: commits.append(None))
        with statements(store) as many:
            large = store.sweeps.create(Submission(sweep_of(LARGE)))
        accepting = {"small": len(few), "large": len(many)}
        of_large = len(commits)
        for number in range(20, 20 + PARTS):
            part = store.sweeps.create(Submission(sweep_of(runs_of(*["fine"] * PART, first=number * LARGE))))
        store.leases.take(LARGE // 5, TERM)
        others = (JOBS.c.id > run_id(9)) & (JOBS.c.id != run_id(10 * LARGE))
        with store.database.writing() as connection:
            ended = JOBS.update().where(JOBS.c.state == State.RUNNING, others)
            connection.execute(ended.values(state=State.SUCCEEDED))
            if not store.database.is_sqlite:  # PostgreSQL does it by itself, SQLite only when told
                connection.exec_driver_sql("ANALYZE")
        older = store.sweeps.page(limit=PARTS + 1).next_cursor
        assert older is not None
        sweeps = (large.id, part.id, small.id, older)
        yield Filled(store, *sweeps, store.keys.issue("anna", [Scope.READ])[1], accepting, of_large)


def _cancel(store: Store) -> None:
    """Sweeps that were cancelled, and published as far as they were."""
    for number in range(5):
        sweep = store.sweeps.create(Submission(sweep_of(runs_of("fine", "fine", first=(50 + number) * LARGE))))
        [first] = lease_runs(store, 1)
        assert store.leases.finish(first, result())
        store.sweeps.cancel(sweep.id)
        finish_all(store)


def test_accept__is_one_transaction_of_two_statements_more_for_each_thousand_runs(filled: Filled) -> None:
    """10 000 runs are accepted in one transaction, of two statements more for each thousand."""
    assert filled.accepting["large"] == filled.accepting["small"] + 2 * ((LARGE - 1) // BATCH)
    assert filled.commits == 1


def _counts(filled: Filled) -> object:
    """The tally of one sweep of a page."""
    with filled.store.database.reading() as connection:
        return tallies_of(connection, [filled.part])


Query = Callable[[Filled], object]
YOUNGER = PARTS + 1  # sweeps: the large one, and those younger
QUERIES: dict[str, Query] = {
    "sweeps": lambda f: f.store.sweeps.page(cursor=f.older),
    "sweeps of a state": lambda f: f.store.sweeps.page(cursor=f.older, state=SweepState.CANCELLED),
    "sweeps with files": lambda f: f.store.sweeps.logbook(Wanted(first=YOUNGER)),
    "sweeps that are searched": lambda f: f.store.sweeps.logbook(Wanted(text="perforation copper", first=YOUNGER)),
    "sweeps, a large one too": lambda f: f.store.sweeps.page(),
    "sweep": lambda f: f.store.sweeps.get(f.part),
    "sweep with files": lambda f: f.store.sweeps.get_with_files(f.part),
    "sweep with a file": lambda f: f.store.sweeps.get_with_file(f.part, "cube.nc"),
    "sweep, the large one": lambda f: f.store.sweeps.get(f.large),
    "counts": _counts,
    "document": lambda f: f.store.sweeps.document(f.part),
    "points": lambda f: f.store.sweeps.points(f.part),
    "points of a state": lambda f: f.store.sweeps.points(f.part, state=State.QUEUED),
    "cells": lambda f: f.store.sweeps.cells(f.part, range(50), "hole_diameter"),
    "places of a run": lambda f: f.store.runs.places(run_id(7), 5),
    "run": lambda f: f.store.runs.get(run_id(7)),
    "spec of a run": lambda f: f.store.runs.spec(run_id(7)),
    "files of a run": lambda f: f.store.runs.files(run_id(7)),
    "events": lambda f: f.store.events.of_sweep(f.part),
    "events of a run": lambda f: f.store.events.of_run(run_id(7)),
    "all events": lambda f: f.store.events.all(),
    "last event": lambda f: f.store.events.last(),
    "runs under way": lambda f: f.store.runs.under_way(),
    "queue": lambda f: f.store.queue.status(),
    "tally": lambda f: f.store.queue.tally(),
    "artifacts": lambda f: f.store.publications.files(f.part),
}


PAGES: dict[str, Callable[[Filled], str]] = {
    "sweeps, for people": lambda f: "/",
    "sweeps": lambda f: "/v1/sweeps",
    "sweeps of a state": lambda f: "/v1/sweeps?state=running",
    "sweep": lambda f: f"/v1/sweeps/{f.large}",
    "document": lambda f: f"/v1/sweeps/{f.large}/document",
    "points": lambda f: f"/v1/sweeps/{f.large}/runs",
    "points of a state": lambda f: f"/v1/sweeps/{f.large}/runs?state=queued",
    "events": lambda f: f"/v1/sweeps/{f.large}/history",
    "run": lambda f: f"/v1/runs/{run_id(7)}",
    "files of a run": lambda f: f"/v1/runs/{run_id(7)}/files",
    "events of a run": lambda f: f"/v1/runs/{run_id(7)}/history",
    "queue": lambda f: "/v1/queue",
}


def _fresh(store: Store) -> Store:
    """The store of a service that has just begun: no tallies are remembered."""
    store.sweeps._tallies._remembered.clear()
    return store


def test_pages__take_at_most_three_statements_with_the_check_of_the_key(filled: Filled, tmp_path: Path) -> None:
    """A page about 10 000 runs takes at most three statements, the check of the key included.

    The service has just begun; the use of the key was noted just before, so that it is not noted now.
    """
    store = filled.store
    with store.database.writing() as connection:
        connection.execute(KEYS.update().values(used=now()))
    app = build_app(Settings(data=tmp_path), store, FakeDispatcher())
    client = TestClient(app, base_url=ADDRESS, headers={"Authorization": f"Bearer {filled.secret}"})
    client.get("/readyz")  # whose outcome the queue shares, here for good
    app.state.readiness._begin = math.inf
    for page, address in PAGES.items():
        with statements(_fresh(store)) as sent:
            response = client.get(address(filled))
        assert response.status_code == 200, response.text
        assert len([text for text in sent if not text.startswith("BEGIN")]) <= PAGE, page


def test_commands__take_as_many_statements_for_many_runs_as_for_one(filled: Filled) -> None:
    """A command on 10 000 runs takes as many statements as on one, a cancel one for each table."""
    commands: dict[str, Callable[[str], object]] = {
        "priority": lambda id: filled.store.sweeps.set_priority(id, 3),
        "cancel": filled.store.sweeps.cancel,
        "retry": filled.store.sweeps.retry,
    }
    for name, command in commands.items():
        with statements(filled.store) as few:
            command(filled.small)
        with statements(filled.store) as many:
            command(filled.large)
        assert len(many) == len(few), name
        if name == "cancel":
            written = Counter(write[1] for text in many if (write := WRITE.match(text)))
            assert set(written.values()) == {1}, written


@contextmanager
def plans(store: Store) -> Iterator[list[str]]:
    """The plans of the statements that the block sends, read before each is executed."""
    texts: list[str] = []
    explain = "EXPLAIN QUERY PLAN" if store.database.is_sqlite else "EXPLAIN"

    def read(_c: Any, cursor: Any, statement: str, parameters: Any, *_rest: Any) -> None:
        if not statement.startswith("BEGIN"):
            first = parameters[0] if isinstance(parameters, list) else parameters  # of many
            cursor.execute(f"{explain} {statement}", first)
            texts.append("\n".join(str(row[-1]) for row in cursor.fetchall()))

    engine = store.database._engine
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
    "last event": {"events"},  # the first row from behind
}


@pytest.mark.parametrize("query", QUERIES)
def test_query__takes_at_most_three_statements_that_read_through_an_index(filled: Filled, query: str) -> None:
    """A query beside 10 000 runs takes at most three statements, and reads no table whole in vain."""
    _fresh(filled.store)
    with plans(filled.store) as asked:
        QUERIES[query](filled)
    assert len(asked) <= PAGE
    reads = [read for plan in asked for read in whole_reads(plan)]
    assert [line for name, line in reads if name not in WHOLE.get(query, ())] == []


def test_read_of_all_jobs__is_seen_in_its_plan(filled: Filled) -> None:
    with plans(filled.store) as asked:
        filled.store.database.rows(sa.select(sa.func.sum(JOBS.c.bytes)))
    assert [name for plan in asked for name, _line in whole_reads(plan)] == ["jobs"]


def test_lease__is_read_through_its_index_in_its_order(filled: Filled) -> None:
    """A claim of the next jobs among 10 000 sorts nothing."""
    with plans(filled.store) as texts:
        assert len(filled.store.leases.take(2, TERM)) == 2
    read = [text for text in texts if "jobs_queue" in text]
    assert len(read) == 3  # publications, shares with work, and the runs of the one owner
    for plan in read:
        assert "TEMP B-TREE" not in plan
        assert "Sort Key: jobs" not in plan
        assert not whole_reads(plan)


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
