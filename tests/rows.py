"""Rows: comparisons that checks, claims and acceptance tests make."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Row:
    """One comparison that a claim makes: what it says, what was expected, what came out."""

    claim: str  # what is compared, with its unit: "hole diameter, 2 km/s (mm)"
    expected: Any  # a number or words: "14.8 within 8 %"
    got: Any  # what was computed now
    passed: bool | None  # None: a figure that is reported and not gated


def within(
    claim: str,
    *,
    expected: float,
    got: float,
    relative: float | None = None,
    absolute: float | None = None,
) -> Row:
    """A row that passes when ``got`` is no farther from ``expected`` than the one tolerance given.

    >>> within("depth (mm)", expected=14.0, got=14.9, absolute=1.5)
    Row(claim='depth (mm)', expected='14 within 1.5', got=14.9, passed=True)
    >>> within("hole (mm)", expected=14.8, got=16.2, relative=0.08).passed
    False
    """
    if (relative is None) == (absolute is None):
        raise TypeError("within() takes one tolerance: relative= or absolute=")
    if relative is not None:
        words, tolerance = f"{expected:g} within {100 * relative:g} %", relative * abs(expected)
    else:
        assert absolute is not None
        words, tolerance = f"{expected:g} within {absolute:g}", absolute
    return Row(claim, words, got, bool(abs(got - expected) <= tolerance))


def at_least(claim: str, *, limit: float, got: float) -> Row:
    """A row that passes when ``got`` reaches a limit; not a number fails.

    >>> at_least("times as fast", limit=4.0, got=3.9).passed
    False
    """
    return Row(claim, f"at least {limit:g}", got, bool(got >= limit))


def at_most(claim: str, *, limit: float, got: float) -> Row:
    """A row that passes when ``got`` does not exceed a limit; not a number fails.

    >>> at_most("energy drift (%)", limit=1.0, got=float("nan")).passed
    False
    """
    return Row(claim, f"at most {limit:g}", got, bool(got <= limit))


def check(rows: Iterable[Row]) -> None:
    """Assert that every row passes; the message lists all of them."""
    compared = list(rows)
    message = "\n".join(f"{row.claim}: expected {row.expected}, got {row.got}" for row in compared)
    assert compared, "nothing was compared"
    assert all(row.passed is not False for row in compared), message
