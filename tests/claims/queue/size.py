"""Ten thousand runs: statements are counted and plans are read, on both databases."""

from collections.abc import Iterator
from contextlib import closing, contextmanager

import sqlalchemy as sa

from service.store import Store
from tests.claims import Row, at_most, claim
from tests.claims.queue._common import folder
from tests.service.by_hand import EPOCH, statements
from tests.service.databases import postgresql_server
from tests.service.doubles import runs_of, sweep_of
from tests.service.test_store_size import LARGE, PAGE, PARTS, QUESTIONS, Filled, plans, whole_tables

TABLES = ("jobs", "points", "sweeps")


@claim(
    "size",
    says="10 000 runs: one transaction to accept, at most three statements a page, read through indices, cancel one "
    "statement a table",
)
def size() -> Iterator[Row]:
    with folder() as place:
        yield from sized("sqlite", f"sqlite:///{place / 'whipple.db'}")
    with postgresql_server() as server, server.database() as url:
        yield from sized("postgresql", url)


def sized(name: str, url: str) -> Iterator[Row]:
    """The rows of one database."""
    with _filled(url) as here:
        yield Row(
            f"{name}: transactions to accept {LARGE} runs", 1, here.commits, here.commits == 1
        )
        few, many = here.said["small"], here.said["large"]
        yield Row(f"{name}: statements to accept {LARGE} runs, as for 1", few, many, few == many)
        for question, ask in QUESTIONS.items():
            with statements(here.store) as sent:
                ask(here)
            count = len([one for one in sent if not one.startswith("BEGIN")])
            yield at_most(f"{name}: statements for {question}", limit=PAGE, got=count)
        yield from _plans(name, here)
        yield from _cancel(name, here)


def _plans(name: str, here: Filled) -> Iterator[Row]:
    for question, tables in PARTS.items():
        with plans(here.store) as told:
            QUESTIONS[question](here)
        whole = [line for plan in told for line in whole_tables(plan, tables)]
        words = f"{name}: tables of which {question} reads every row"
        yield Row(words, "none", ", ".join(whole) or "none", not whole)
    with plans(here.store) as told:
        here.store.claim(2, EPOCH)
    [take] = [plan for plan in told if "jobs_queue" in plan]
    is_sorted = "TEMP B-TREE" in take or "Sort Key: jobs" in take
    yield Row(f"{name}: a claim sorts the queue", "no", "yes" if is_sorted else "no", not is_sorted)


def _cancel(name: str, here: Filled) -> Iterator[Row]:
    """How often each table is written to."""
    with statements(here.store) as sent:
        here.store.cancel_sweep(here.large)
    for table in TABLES:
        writes = [
            one for one in sent if one.startswith((f"UPDATE {table}", f"DELETE FROM {table}"))
        ]
        yield Row(f"{name}: statements on {table} to cancel", 1, len(writes), len(writes) == 1)


@contextmanager
def _filled(url: str) -> Iterator[Filled]:
    """A store with a large sweep and a small one."""
    with closing(Store.open(url, cost=lambda run: 1.0)) as store:
        with statements(store) as few:
            small = store.create_sweep(sweep_of(runs_of("fine", first=10 * LARGE)))
        commits: list[None] = []
        sa.event.listen(store._database._engine, "commit", lambda _: commits.append(None))
        with statements(store) as many:
            large = store.create_sweep(sweep_of(LARGE))
        counts, said = len(commits), {"small": len(few), "large": len(many)}
        store.claim(LARGE // 5, EPOCH)  # something has happened
        with store._database.writing() as connection:
            connection.exec_driver_sql("ANALYZE")
        yield Filled(store, large.id, small.id, said, counts)
