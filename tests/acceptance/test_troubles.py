"""Failures around a service or within a run."""

from functools import partial

import pytest

from tests.acceptance.checks import troubles
from tests.rows import check

SHORT_TIMEOUTS = ("-m", "tests.acceptance.support.short_timeouts")


@pytest.mark.slow
@pytest.mark.parametrize(
    "rows",
    [
        troubles.failing_runs,
        partial(troubles.database_locked, program=SHORT_TIMEOUTS),
        partial(troubles.disk_full, program=SHORT_TIMEOUTS),
        troubles.database_away,
        troubles.clock_set,
    ],
    ids=["failing-runs", "database-locked", "disk-full", "database-away", "clock-set"],
)
def test_trouble__loses_nothing(rows: troubles.Check) -> None:
    try:
        check(rows())
    except PermissionError as error:  # a container; the claim trouble-disk fails in words there
        pytest.skip(str(error))
