"""The framework of a row: every compared figure of a claim.

A row names the compared quantity, the expected and the computed value, the error and its tolerance. A tolerance is set
from the numerics' order or from what the answer is needed for; a row without one is reported, and ``reported`` asks
that its figure is a number.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

from studies.quantities import comparison
from studies.quantities.comparison import Comparison


@dataclass(frozen=True)
class Row(Comparison):
    """A compared figure of anything, which may have an order of convergence."""

    expected: Any  # the exact answer, or the limit in words; "" where there is none
    got: Any  # computed now
    order: float | None = None  # observed order of convergence

    def ungated(self, limit: float | None = None) -> Self:
        """The row as a report; with ``limit`` its claim says whether that gate would hold."""
        if self.passed is None:
            return self
        return super().ungated(limit) if limit is not None else replace(self, passed=None, tolerance=None)

    def __str__(self) -> str:
        return super().__str__() + ("" if self.order is None else f" | order {self.order:.2f}")


def relative(
    claim: str, *, expected: float, got: float, within: float | None = None, order: float | None = None
) -> Row:
    """A row whose error is relative to the exact answer."""
    return Row(**vars(comparison.relative(claim, expected=expected, got=got, within=within)), order=order)


def absolute(claim: str, *, expected: float, got: float, within: float | None = None) -> Row:
    """A row whose error is in the unit of the answer."""
    return Row(**vars(comparison.absolute(claim, expected=expected, got=got, within=within)))


def at_most(claim: str, *, limit: float, got: float) -> Row:
    """A row that passes when a figure does not exceed a limit; the error is the excess."""
    return Row(**vars(comparison.at_most(claim, limit=limit, got=got)))


def reported(claim: str, got: float, *, order: float | None = None) -> Row:
    """A figure without an expected value; it fails where it is not a finite number."""
    return Row(**vars(comparison.reported(claim, got)), order=order)


def relatives(where: str, *figures: tuple[str, float, float, float | None]) -> Iterator[Row]:
    """Rows of ``relative`` with a common beginning of their claims: claim, expected, got and tolerance of each."""
    for claim, expected, got, within in figures:
        yield relative(f"{where}: {claim}", expected=expected, got=got, within=within)


def zero(claim: str, *, got: float, within: float | None = None) -> Row:
    """A row of a figure whose answer is zero."""
    return absolute(claim, expected=0.0, got=got, within=within)


def at_least(claim: str, *, limit: float, got: float) -> Row:
    """A row that passes when a figure does not fall below a limit; the error is the shortfall."""
    short = limit - got if math.isnan(got) else max(limit - got, 0.0)
    return Row(claim, f"at least {limit:g}", got, bool(short <= 0.0), short, 0.0)


def equal(claim: str, *, expected: Any, got: Any) -> Row:
    """A row that passes when two values are equal."""
    return Row(claim, expected, got, bool(got == expected))


def observed_order(errors: Iterable[float]) -> float:
    """Order of convergence between the two finest grids of a series, coarse to fine, each twice as fine.

    >>> observed_order([0.16, 0.04, 0.01])
    2.0
    """
    coarse, fine = list(errors)[-2:]
    if not (coarse > 0.0 and fine > 0.0):
        return math.nan
    return math.log2(coarse / fine)


def trend(claim: str, errors: Sequence[float]) -> Row:
    """A reported row of the error on the finest grid of a series with its observed order; of no error there is none."""
    order = observed_order(errors)
    return reported(claim, errors[-1], order=None if math.isnan(order) else order)


def refinement(claim: str, sizes: Sequence[float], errors: Sequence[float]) -> Iterator[Row]:
    """Reported rows of the errors of a series, coarse to fine, the observed order at the last; ``{}`` is the size."""
    for number, (size, error) in enumerate(zip(sizes, errors, strict=True), start=1):
        order = observed_order(errors) if number == len(errors) else None
        yield reported(claim.format(size), error, order=order)
