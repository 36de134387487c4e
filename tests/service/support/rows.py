"""Leases taken and ended by hand, and the statements that a store sends to its database."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import sqlalchemy as sa

from service.records.jobs import Keep, Kind, Lease, Result, State, Stored
from service.store import Store
from tests.service.support.fakes import run_id, stored

TERM = 1


def lease_of(**changes: Any) -> Lease:
    """A lease of a run that no store has given."""
    plain = Lease(run_id(7), Kind.RUN, 1, TERM, "c0ffee00", 0, None, 0, Keep.FINAL, State.RUNNING, None, None)
    return replace(plain, **changes)


def result(*others: Stored, succeeded: bool = True) -> Result:
    """A result with its answer and other files."""
    reason = None if succeeded else "density = 3e4"
    failure = None if succeeded else "UnphysicalState"
    files = (stored(), *others)
    return Result(files, succeeded, reason, failure, {"numbers": {"steps": 7.0}}, 2.0)


def finish_all(store: Store, *files: Stored, succeeded: bool = True, term: int = TERM) -> None:
    """Compute everything that is queued, publications included; runs leave these files beside their results."""
    while leases := store.leases.take(100, term):
        for lease in leases:
            if lease.kind is Kind.PUBLISH:
                assert store.leases.publish(lease, [stored("cube.nc", "cube.nc")], seconds=1.0)
            else:
                assert store.leases.finish(lease, result(*files, succeeded=succeeded))


def lease_runs(store: Store, count: int) -> list[Lease]:
    """Lease this number of jobs, which must be runs."""
    leases = store.leases.take(count, TERM)
    assert [lease.kind for lease in leases] == [Kind.RUN] * count
    return list(leases)


@contextmanager
def statements(store: Store) -> Iterator[list[str]]:
    """The statements that the block sends, transactions included."""
    sent: list[str] = []

    def note(_c: Any, _cursor: Any, statement: str, *_rest: Any) -> None:
        sent.append(statement)

    engine = store.database._engine
    sa.event.listen(engine, "before_cursor_execute", note)
    try:
        yield sent
    finally:
        sa.event.remove(engine, "before_cursor_execute", note)
