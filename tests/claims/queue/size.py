"""Ten thousand runs: statements are counted and plans are read, on both databases."""

from collections.abc import Iterator
from pathlib import Path

from tests.claims import Row, at_most, claim
from tests.claims.queue._common import folder
from tests.service.by_hand import EPOCH, statements
from tests.service.databases import postgresql_server
from tests.service.test_store_size import (
    LARGE,
    PAGE,
    PAGES,
    QUESTIONS,
    Filled,
    filling,
    plans,
    statements_for,
    whole_tables_of,
)

TABLES = ("jobs", "points", "sweeps")


@claim(
    "size",
    says="10 000 runs: one transaction to accept, at most three statements a page, read through indices, cancel one "
    "statement a table",
)
def size() -> Iterator[Row]:
    with folder() as place:
        yield from sized("sqlite", f"sqlite:///{place / 'whipple.db'}", place)
        with postgresql_server() as server, server.database() as url:
            yield from sized("postgresql", url, place)


def sized(name: str, url: str, place: Path) -> Iterator[Row]:
    """The rows of one database."""
    with filling(url) as here:
        yield Row(
            f"{name}: transactions to accept {LARGE} runs", 1, here.commits, here.commits == 1
        )
        few, many = here.said["small"], here.said["large"]
        yield Row(f"{name}: statements to accept {LARGE} runs, as for 1", few, many, few == many)
        for page in PAGES:
            count = statements_for(here, page, place)
            yield at_most(f"{name}: statements for the page {page}", limit=PAGE, got=count)
        yield from _plans(name, here)
        yield from _cancel(name, here)


def _plans(name: str, here: Filled) -> Iterator[Row]:
    for question in QUESTIONS:
        whole = whole_tables_of(here, question)
        words = f"{name}: tables of which {question} reads every row in vain"
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
