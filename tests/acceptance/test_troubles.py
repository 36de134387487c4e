"""What goes wrong around a service or in a run."""

import pytest

from tests.acceptance.rows import holds, upholds
from tests.claims.queue import troubles

HASTY = ("-m", "tests.acceptance.hasty")


@pytest.mark.slow
def test_runs_in_trouble__have_the_named_end_and_no_neighbour_notices() -> None:
    upholds(troubles.troubles_of_runs)


@pytest.mark.slow
def test_database_locked__is_refused_in_words_and_waited_for() -> None:
    holds(troubles.locked(program=HASTY))


@pytest.mark.slow
def test_disk_full__nothing_is_begun_and_nothing_lost() -> None:
    try:
        holds(troubles.full(program=HASTY))
    except (
        PermissionError
    ) as error:  # in most containers; ``make claims trouble-disk`` says so as a failure
        pytest.skip(str(error))


@pytest.mark.slow
def test_database_away__is_waited_for() -> None:
    upholds(troubles.trouble_away)


@pytest.mark.slow
def test_clock_set_back__changes_nothing() -> None:
    holds(troubles.clock_set())
