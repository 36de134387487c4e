"""Rows of claims and crash tests: the records of ``studies.cases.rows``, and a test's assertion on them."""

from collections.abc import Iterable

from studies.cases.rows import Row, absolute, at_least, at_most, equal, relative

__all__ = ["Row", "absolute", "at_least", "at_most", "check", "equal", "relative"]


def check(rows: Iterable[Row]) -> None:
    """Assert that every row passes; the message lists all of them."""
    compared = list(rows)
    assert compared, "nothing was compared"
    assert all(row.passed is not False for row in compared), "\n".join(map(str, compared))
