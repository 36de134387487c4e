"""The crash test in its short form; the full one is a claim of the queue."""

from collections.abc import Callable, Iterator
from functools import partial

import pytest

from tests.acceptance.checks import fault_points, kills
from tests.rows import Row, check


@pytest.mark.slow
@pytest.mark.parametrize(
    "rows",
    [
        pytest.param(partial(kills.crash_test_rows, kills.SHORT), id="sqlite"),
        pytest.param(partial(kills.crash_test_rows, kills.SHORT_EXTERNAL), id="postgresql-dask"),
        pytest.param(fault_points.in_short, id="fault-points"),
        pytest.param(fault_points.of_a_copy, id="copy"),
    ],
)
def test_kill__loses_nothing(rows: Callable[[], Iterator[Row]]) -> None:
    check(rows())
