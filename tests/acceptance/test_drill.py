"""The kill drill in its short form; the full one is a claim of the queue."""

import pytest

from tests.acceptance.rows import holds
from tests.claims.queue import faults, kills


@pytest.mark.slow
def test_kills__on_sqlite_lose_nothing() -> None:
    holds(kills.drilled(kills.SHORT, kills.SEED))


@pytest.mark.slow
def test_kills__on_postgresql_with_a_scheduler_lose_nothing() -> None:
    holds(kills.drilled(kills.SHORT_EXTERNAL, kills.SEED))


@pytest.mark.slow
def test_fault_points__each_leaves_a_store_that_is_consistent() -> None:
    holds(faults.in_short())


@pytest.mark.slow
def test_copy__that_is_killed_halfway_is_completed() -> None:
    holds(faults.of_a_copy())
