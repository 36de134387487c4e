"""A store with much history: what is asked again and again reads what has not ended, with statistics or without."""

from collections.abc import Callable, Iterator
from contextlib import closing
from datetime import timedelta

import pytest

from service.records.jobs import Quota, Submission
from service.store import Store
from service.store.tables import now
from tests.service.store.test_size import plans, whole_reads
from tests.service.support import history
from tests.service.support.fakes import runs_of, sweep_of
from tests.service.support.rows import TERM

HISTORY = history.History(sweeps=300, abandoned=300)
QUOTA = Quota(200, 200_000, 2 << 40)


@pytest.fixture(scope="module")
def old(module_url: str) -> Iterator[Store]:
    """A store with history, and a few runs that wait and are computed."""
    with closing(Store.open(module_url)) as store:
        history.write(store, HISTORY)
        for number, owner in enumerate(("anna", "zoe"), 1):
            runs = runs_of(*["fine"] * 4, first=number << 100)
            store.sweeps.create(Submission(sweep_of(runs), owner=owner))
        store.leases.take(3, TERM)
        if not store.database.is_sqlite:  # as it does by itself
            history.analyze(store)
        yield store


ASKED: dict[str, Callable[[Store], object]] = {
    "leases": lambda store: store.leases.held(),
    "due jobs": lambda store: store.leases.take(1, TERM),
    "runs under way": lambda store: store.runs.under_way(),
    "runs of owners": lambda store: store.queue.tally_of_owners(),
    "results": lambda store: store.queue.tally(),
    "head of the queue": lambda store: store.queue.head(),
    "measured rate": lambda store: store.runs.measured_rate("thin_plate"),
    "forgotten runs": lambda store: store.retention.forget_runs(now() - timedelta(days=30), 50),
    "expired sweeps": lambda store: store.retention.expired(now() - timedelta(days=30)),
    "files without a sweep": lambda store: store.retention.discardable(50, "7f"),
}


def of_history(asked: list[str]) -> list[str]:
    """Lines of plans that read a long table whole: the last event is the first from behind, few jobs are unfinished."""
    reads = (read for plan in asked for read in whole_reads(plan))
    few = ("jobs_active", "jobs_queue")
    return [line for table, line in reads if table != "events" and not any(index in line for index in few)]


@pytest.mark.parametrize("has_statistics", [False, True])
def test_history__is_not_read_by_what_is_asked_again_and_again(old: Store, has_statistics: bool) -> None:
    if has_statistics:
        history.analyze(old)
    for name, ask in ASKED.items():
        with plans(old) as asked:
            ask(old)
        assert asked, name
        assert of_history(asked) == [], name


@pytest.mark.parametrize("has_statistics", [False, True])
def test_submission__with_a_quota_reads_no_history(old: Store, has_statistics: bool) -> None:
    if has_statistics:
        history.analyze(old)
    runs = runs_of("fine", "fine", first=(3 + has_statistics) << 100)
    with plans(old) as asked:
        old.sweeps.create(Submission(sweep_of(runs), owner="anna", quota=QUOTA))
    assert any("jobs_owned" in plan for plan in asked)
    assert of_history(asked) == []
