"""What goes wrong around a service or in a run; disks and locks, which take longer, are claims of the queue."""

import pytest

from tests.acceptance.rows import upholds
from tests.claims.queue import troubles


@pytest.mark.slow
def test_runs_in_trouble__have_the_named_end_and_no_neighbour_notices() -> None:
    upholds(troubles.troubles_of_runs)


@pytest.mark.slow
def test_database_away__is_waited_for() -> None:
    upholds(troubles.trouble_away)


@pytest.mark.slow
def test_clock_set_back__changes_nothing() -> None:
    upholds(troubles.trouble_clock)
