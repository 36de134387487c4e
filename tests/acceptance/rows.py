"""Rows of claims as assertions of tests."""

from collections.abc import Iterable

from tests.claims import Claim, Row


def upholds(one: Claim) -> None:
    """A claim in its full form holds."""
    rows = one.check()
    holds([rows] if isinstance(rows, Row) else rows)


def holds(rows: Iterable[Row]) -> None:
    """Every row passes; says all of them when one does not."""
    found = list(rows)
    words = "\n".join(f"{row.claim}: expected {row.expected}, got {row.got}" for row in found)
    print(words)
    assert found, "nothing was compared"
    assert all(row.passed is not False for row in found), words
