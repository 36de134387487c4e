"""People and dispatchers at the same moment: replicas on one database, each in a thread of its own.

Each replica has connections of its own, as a process of its own would have.
"""

from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, closing, suppress
from threading import Barrier

import pytest
import sqlalchemy as sa

from service.records.jobs import Cause, Conflict, Kind, Lease, State, Submission
from service.store import Store
from service.store.tables import JOBS, POINTS
from tests.service.support.fakes import runs_of, stored, sweep_of
from tests.service.support.rows import TERM, finish_all, result

REPLICAS = 4
ROUNDS = 3
PATIENCE = 120.0  # s, for everything that is done at once


@pytest.fixture
def replicas(database_url: str) -> Iterator[list[Store]]:
    with ExitStack() as ends:
        yield [ends.enter_context(closing(Store.open(database_url))) for _ in range(REPLICAS)]


def at_once(*doings: Callable[[], object]) -> list[object]:
    """Do things at the same moment, each in a thread; the first exception is raised."""
    ready = Barrier(len(doings))

    def begin(doing: Callable[[], object]) -> object:
        ready.wait(PATIENCE)
        return doing()

    with ThreadPoolExecutor(len(doings)) as pool:
        return [future.result(PATIENCE) for future in [pool.submit(begin, one) for one in doings]]


def check(store: Store) -> None:
    """Nobody waits in vain, nothing is queued for nobody, and what is done is known."""
    active = [State.QUEUED, State.RUNNING, State.CANCELLING]
    publications = sa.alias(JOBS, "publications")
    waiting = (
        sa.select(POINTS.c.run_id, POINTS.c.sweep_id, JOBS.c.state)
        .join_from(POINTS, JOBS, JOBS.c.id == POINTS.c.run_id)
        .join(publications, publications.c.sweep_id == POINTS.c.sweep_id)
        .where(publications.c.state == State.WAITING, POINTS.c.detached.is_(False))
    )
    queued = sa.select(JOBS.c.id).where(JOBS.c.kind == Kind.RUN, JOBS.c.state == State.QUEUED)
    pending = sa.select(JOBS.c.sweep_id).where(JOBS.c.state == State.WAITING)
    with store.database.reading() as connection:
        rows = connection.execute(waiting).all()
        assert set(connection.scalars(pending)) == {row.sweep_id for row in rows if row.state in active}
        assert set(connection.scalars(queued)) <= {row.run_id for row in rows}


def test_idempotency__two_at_once_are_one_sweep(replicas: list[Store]) -> None:
    for number in range(ROUNDS):
        key = (f"key-{number}", "11" * 32)

        def submit(store: Store, key: tuple[str, str] = key) -> Callable[[], object]:
            return lambda: store.sweeps.create(Submission(sweep_of(3), owner="ann", idempotency=key))

        rows = at_once(*(submit(store) for store in replicas))
        assert len({row.id for row in rows}) == 1  # type: ignore[attr-defined]
    assert len(replicas[0].sweeps.page().items) == ROUNDS


def test_everything_at_once__ends_and_counts_match(replicas: list[Store]) -> None:
    people, others, dispatcher, second = replicas
    taken: list[tuple[str, int]] = []

    def submit_and_cancel(store: Store, share: int) -> Callable[[], object]:
        def work() -> None:
            for number in range(12):
                first = (number * 3 + share) % 10
                row = store.sweeps.create(Submission(sweep_of(runs_of(*["fine"] * 4, first=first))))
                if number % 3 == share:
                    store.sweeps.cancel(row.id)
                with suppress(Conflict):  # it may have ended
                    store.sweeps.set_priority(row.id, number)

        return work

    def compute(store: Store) -> Callable[[], object]:
        def work() -> None:
            for number in range(40):
                for lease in store.leases.take(2, TERM):
                    taken.append((lease.id, lease.attempt))
                    end(store, lease, number)

        return work

    at_once(submit_and_cancel(people, 0), submit_and_cancel(others, 1), compute(dispatcher), compute(second))
    check(dispatcher)
    assert len(taken) == len(set(taken))  # two dispatchers never get the same attempt
    for lease in dispatcher.leases.held():
        dispatcher.leases.requeue(lease, Cause.LOST, reason="stopped")
    finish_all(dispatcher)
    for row in dispatcher.sweeps.page(limit=1000).items:
        assert row.is_terminal
        assert sum(row.counts.values()) == row.planned


def end(store: Store, lease: Lease, number: int) -> None:
    if lease.kind is Kind.PUBLISH:
        store.leases.publish(lease, [stored("cube.nc")], seconds=1.0)
    elif number % 4 == 0:
        store.leases.requeue(lease, Cause.LOST, reason="worker lost")
    else:
        store.leases.finish(lease, result(succeeded=number % 3 > 0))


def test_events__become_visible_in_the_order_of_their_numbers(replicas: list[Store]) -> None:
    *writers, reader = replicas
    done: list[None] = []
    seen: list[int] = []

    def write(store: Store, first: int) -> Callable[[], object]:
        def work() -> None:
            try:
                for number in range(10):
                    store.sweeps.create(Submission(sweep_of(runs_of("fine", first=first + number))))
            finally:
                done.append(None)

        return work

    def follow() -> None:
        while len(done) < len(writers):
            seen.extend(event.number for event in reader.events.all(after=max(seen, default=0)))

    at_once(*(write(store, 1000 * n) for n, store in enumerate(writers)), follow)
    seen.extend(event.number for event in reader.events.all(after=max(seen, default=0)))
    assert seen == [event.number for event in reader.events.all()]
