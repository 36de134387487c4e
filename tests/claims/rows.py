"""The framework of a row: every compared figure of a claim.

A row names the compared quantity, the expected and the computed value, the error and its tolerance. A tolerance is set
from the numerics' order or from what the answer is needed for; a row without one is reported, and ``reported`` asks
that its figure is a number.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any


@dataclass(frozen=True)
class Row:
    """A compared figure: its claim, the expected and the computed value, and whether it passes."""

    claim: str  # the compared quantity, with its unit: "plateau pressure, Cu 6 km/s (GPa)"
    expected: Any  # the exact answer, or the limit in words; "" where there is none
    got: Any  # computed now
    passed: bool | None  # None: reported, not gated
    error: float = math.nan  # relative to the answer, or in the unit of the claim; NaN: none
    tolerance: float | None = None  # tolerance of the error
    order: float | None = None  # observed order of convergence
    bar: float | None = None  # numerical uncertainty of what was computed, in its unit
    others: Mapping[str, Any] = field(default_factory=dict)  # what others computed, by their names

    @property
    def verdict(self) -> str:
        """PASS, FAIL or REPORT."""
        return {None: "REPORT", True: "PASS", False: "FAIL"}[self.passed]

    def ungated(self, limit: float | None = None) -> "Row":
        """The row as a report; with ``limit`` its claim says whether that gate would hold."""
        if self.passed is None:
            return self
        note = "" if limit is None else f", {'holds' if self.passed else 'misses'} {limit:g}"
        return replace(self, claim=self.claim + note, passed=None, tolerance=None)

    def __str__(self) -> str:
        return " | ".join(
            (
                f"{self.verdict:6}",
                self.claim,
                "reported" if self.expected == "" else f"expected {_figure(self.expected)}",
                f"got {_figure(self.got)}" + ("" if self.bar is None else f" ± {self.bar:.3g}"),
                *([] if math.isnan(self.error) else [f"error {self.error:.3g}"]),
                *([] if self.tolerance is None else [f"tolerance {self.tolerance:g}"]),
                *([] if self.order is None else [f"order {self.order:.2f}"]),
                *(f"{name} {_figure(value)}" for name, value in self.others.items()),
            )
        )

    def as_json(self) -> dict[str, Any]:
        """As plain objects; a number that is not finite is null."""
        plain = {each.name: _plain(getattr(self, each.name)) for each in fields(self)}
        return {**plain, "verdict": self.verdict}


@dataclass(frozen=True)
class Verified:
    """A computed row of a claim with the wall time since the row before it."""

    case: str
    row: Row
    seconds: float

    def as_json(self) -> dict[str, Any]:
        """As plain objects."""
        return {"case": self.case, **self.row.as_json(), "seconds": round(self.seconds, 3)}


def _plain(value: Any) -> Any:
    """A value that JSON can hold."""
    if isinstance(value, Mapping):
        return {name: _plain(item) for name, item in value.items()}
    if isinstance(value, bool | int | str) or value is None:
        return value
    try:
        number = float(value)
    except (TypeError, ValueError):
        return str(value)
    return number if math.isfinite(number) else None


def _figure(value: Any) -> str:
    """A value as one line, numbers with six digits."""
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return " ".join(text.split())


def relative(
    claim: str, *, expected: float, got: float, within: float | None = None, order: float | None = None
) -> Row:
    """A row whose error is relative to the exact answer."""
    return _row(claim, expected, got, abs(got - expected) / abs(expected), within, order)


def relatives(where: str, *figures: tuple[str, float, float, float | None]) -> Iterator[Row]:
    """Rows of ``relative`` with a common beginning of their claims: claim, expected, got and tolerance of each."""
    for claim, expected, got, within in figures:
        yield relative(f"{where}: {claim}", expected=expected, got=got, within=within)


def absolute(claim: str, *, expected: float, got: float, within: float | None = None) -> Row:
    """A row whose error is in the unit of the answer."""
    return _row(claim, expected, got, abs(got - expected), within)


def zero(claim: str, *, got: float, within: float | None = None) -> Row:
    """A row of a figure whose answer is zero."""
    return absolute(claim, expected=0.0, got=got, within=within)


def at_most(claim: str, *, limit: float, got: float) -> Row:
    """A row that passes when a figure does not exceed a limit; the error is the excess."""
    return _row(claim, f"at most {limit:g}", got, _excess(got - limit), 0.0)


def at_least(claim: str, *, limit: float, got: float) -> Row:
    """A row that passes when a figure does not fall below a limit; the error is the shortfall."""
    return _row(claim, f"at least {limit:g}", got, _excess(limit - got), 0.0)


def equal(claim: str, *, expected: Any, got: Any) -> Row:
    """A row that passes when two values are equal."""
    return Row(claim, expected, got, bool(got == expected))


def reported(claim: str, got: float, *, order: float | None = None) -> Row:
    """A figure without an expected value; it fails where it is not a finite number."""
    if math.isfinite(got):
        return _row(claim, "", got, math.nan, None, order)
    return _row(claim, "a number", got, math.nan, 0.0, order)


def _row(
    claim: str, expected: float | str, got: float, error: float, tolerance: float | None, order: float | None = None
) -> Row:
    """A row that passes when its error is within its tolerance; not a number fails."""
    passed = None if tolerance is None else bool(error <= tolerance)
    return Row(claim, expected, got, passed, error, tolerance, order)


def _excess(value: float) -> float:
    return value if math.isnan(value) else max(value, 0.0)


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
