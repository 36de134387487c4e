"""What a dispatcher does to a store, done by hand, and what a store says to its database."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import sqlalchemy as sa

from service.records.jobs import Claim, Kind, Result, Stored
from service.store import Store
from tests.service.support.fakes import stored

TERM = 1


def result(*others: Stored, succeeded: bool = True) -> Result:
    """A result with its answer and other files."""
    reason = None if succeeded else "density = 3e4"
    failure = None if succeeded else "UnphysicalState"
    files = (stored(), *others)
    return Result(files, succeeded, reason, failure, {"numbers": {"steps": 7.0}}, 2.0)


def finish_all(store: Store, *, succeeded: bool = True, epoch: int = TERM) -> None:
    """Compute everything that is queued, publications included."""
    while claims := store.claim(100, epoch):
        for claim in claims:
            if claim.kind is Kind.PUBLISH:
                assert store.publish(claim, [stored("cube.nc", "cube.nc")], seconds=1.0)
            else:
                assert store.finish(claim, result(succeeded=succeeded))


def claim_runs(store: Store, count: int) -> list[Claim]:
    """Claim so many jobs, which must be runs."""
    claims = store.claim(count, TERM)
    assert [claim.kind for claim in claims] == [Kind.RUN] * count
    return list(claims)


@contextmanager
def statements(store: Store) -> Iterator[list[str]]:
    """The statements that the block sends, transactions included."""
    sent: list[str] = []

    def note(_c: Any, _cursor: Any, statement: str, *_rest: Any) -> None:
        sent.append(statement)

    engine = store._database._engine
    sa.event.listen(engine, "before_cursor_execute", note)
    try:
        yield sent
    finally:
        sa.event.remove(engine, "before_cursor_execute", note)
