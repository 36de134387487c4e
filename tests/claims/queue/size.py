"""Ten thousand runs: statements are counted and plans are read, on both databases."""

import re
from collections import Counter
from collections.abc import Iterator
from itertools import product
from pathlib import Path

from tests.acceptance.checks.common import folder
from tests.claims import Row, at_most, claim
from tests.service.store.test_size import (
    LARGE,
    PAGE,
    PAGES,
    QUERIES,
    Filled,
    filling,
    plans,
    statements_for,
    whole_tables_of,
)
from tests.service.support.databases import postgresql_server
from tests.service.support.rows import TERM, statements

WRITE = re.compile(r"(?:UPDATE|DELETE FROM|INSERT INTO) (\w+)")


@claim(
    "size",
    says="10 000 runs: one transaction to accept, at most three statements a page, also with a key, read through "
    "indices, cancel one statement a table",
)
def size() -> Iterator[Row]:
    with folder() as place:
        yield from sized("sqlite", f"sqlite:///{place / 'whipple.db'}", place)
        with postgresql_server() as server, server.database() as url:
            yield from sized("postgresql", url, place)


def sized(name: str, url: str, place: Path) -> Iterator[Row]:
    """The rows of one database."""
    with filling(url) as here:
        yield Row(f"{name}: transactions to accept {LARGE} runs", 1, here.commits, here.commits == 1)
        few, many = here.accepting["small"], here.accepting["large"]
        yield Row(f"{name}: statements to accept {LARGE} runs, as for 1", few, many, few == many)
        for page, with_key in product(PAGES, (False, True)):
            count = statements_for(here, page, place / name, with_key=with_key)
            words = f"{name}: statements for the page {page}{', with a key' if with_key else ''}"
            yield at_most(words, limit=PAGE, got=count)
        yield from _plans(name, here)
        yield from _cancel(name, here)


def _plans(name: str, here: Filled) -> Iterator[Row]:
    for query in QUERIES:
        whole = whole_tables_of(here, query)
        words = f"{name}: tables of which {query} reads every row in vain"
        yield Row(words, "none", ", ".join(whole) or "none", not whole)
    with plans(here.store) as told:
        here.store.lease(2, TERM)
    [take] = [plan for plan in told if "jobs_queue" in plan]
    is_sorted = "TEMP B-TREE" in take or "Sort Key: jobs" in take
    yield Row(f"{name}: a claim sorts the queue", "no", "yes" if is_sorted else "no", not is_sorted)


def _cancel(name: str, here: Filled) -> Iterator[Row]:
    """What is sent to cancel, and how often each table is written to."""
    few, many = _sent_to_cancel(here, here.small), _sent_to_cancel(here, here.large)
    words = f"{name}: statements to cancel {LARGE} runs, as for 1"
    yield Row(words, len(few), len(many), len(many) == len(few))
    for table, writes in sorted(Counter(filter(None, map(_written, many))).items()):
        yield Row(f"{name}: of these, writes to {table}", 1, writes, writes == 1)


def _sent_to_cancel(here: Filled, sweep_id: str) -> list[str]:
    with statements(here.store) as sent:
        here.store.cancel_sweep(sweep_id)
    return sent


def _written(statement: str) -> str | None:
    """The table that a statement writes to, whatever it does there."""
    write = WRITE.match(statement)
    return write[1] if write else None
