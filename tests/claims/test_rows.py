"""Rows of claims cannot hide a failure."""

import math

import pytest

from tests.claims.rows import Row, absolute, at_least, at_most, equal, relative, reported

NAN = math.nan


@pytest.mark.parametrize(
    ("row", "verdict"),
    [
        (relative("x", expected=14.8, got=15.9, within=0.08), "PASS"),
        (relative("x", expected=-2.0, got=-2.2, within=0.06), "FAIL"),
        (relative("x", expected=1.0, got=NAN, within=0.1), "FAIL"),
        (relative("x", expected=1.0, got=9.0), "REPORT"),
        (absolute("x", expected=14.0, got=15.5, within=1.5), "PASS"),
        (absolute("x", expected=0.0, got=NAN, within=0.1), "FAIL"),
        (at_most("x", limit=1.0, got=1.0), "PASS"),
        (at_most("x", limit=1.0, got=NAN), "FAIL"),
        (at_least("x", limit=4.0, got=3.9), "FAIL"),
        (equal("x", expected="none", got="none"), "PASS"),
        (equal("x", expected=NAN, got=NAN), "FAIL"),
        (reported("x", 9.0), "REPORT"),
        (reported("x", NAN), "FAIL"),
        (at_most("x", limit=1.0, got=2.0).ungated(), "REPORT"),
    ],
)
def test_row__passes_within_its_tolerance_only(row: Row, verdict: str) -> None:
    assert row.verdict == verdict
    assert str(row).startswith(verdict)
