"""Verification: problems whose answer is known exactly, and what the solver makes of them.

How to add one: a module here that offers a ``Case`` as ``CASE``. Its ``run`` takes the numerics (a ``Recipe``) and
yields rows: what is compared, what the exact answer is, what came out, how far it is off, and how far it may be. A
tolerance is set from the numerics' order or from what the answer is needed for; a row without one is reported, and
``reported`` asks that its figure is a number. Where the figure was known when the tolerance, or what it gates, was
decided, the line says so: ``thesis_bar`` (the grid of 8 cells), ``contact`` (parting, sliding), ``vibrating_bar`` (the
finest pair), ``sod`` (GIMP), ``energy`` (the hottest share), ``absorbing`` (the burst), ``absorbing_block`` (its size).
Exact answers are functions of their own, in modules whose name starts with an underscore, with their own doctests; they
share no code with the solver. Nothing here is heavy to import: ``run`` alone reaches for the solver.

``verify`` runs cases and ``whipple validate --verification`` prints them; ``tests/claims`` makes each a claim, and the
test command runs those that are quick. ``tests/verification`` tests this frame and fields with an exact answer.
"""

import math
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from typing import Any

from solver.errors import WhippleError
from solver.registry import entries
from studies.values.nearest import nearest_cure
from studies.values.quantities import refusal
from studies.values.recipes import RECIPES, Recipe

DEFAULT = RECIPES["whipple"]


@dataclass(frozen=True)
class Row:
    """One comparison with an exact answer."""

    claim: str  # what is compared, with its unit: "plateau pressure, Cu 6 km/s (GPa)"
    expected: float | str  # the exact answer, or the limit in words
    got: float
    error: float  # as the tolerance counts it: relative to the answer, or in the unit of the claim; NaN: none
    tolerance: float | None  # None: reported, not gated
    order: float | None = None  # observed order of convergence

    @property
    def passed(self) -> bool | None:
        """Whether the error is within the tolerance; None where it is reported. Not a number fails."""
        return None if self.tolerance is None else bool(self.error <= self.tolerance)

    @property
    def verdict(self) -> str:
        """PASS, FAIL or REPORT."""
        return {None: "REPORT", True: "PASS", False: "FAIL"}[self.passed]

    def __str__(self) -> str:
        return " | ".join(
            (
                f"{self.verdict:6}",
                self.claim,
                f"expected {_figure(self.expected)}" if self.expected != "" else "reported",
                f"got {_figure(self.got)}",
                *([] if math.isnan(self.error) else [f"error {self.error:.3g}"]),
                *([] if self.tolerance is None else [f"tolerance {self.tolerance:g}"]),
                *([] if self.order is None else [f"order {self.order:.2f}"]),
            )
        )

    def as_json(self) -> dict[str, Any]:
        """As plain objects; what is not a number is null."""
        plain = {**asdict(self), "verdict": self.verdict}
        return {
            name: None if isinstance(value, float) and not math.isfinite(value) else value
            for name, value in plain.items()
        }


@dataclass(frozen=True)
class Case:
    """A problem with a known answer."""

    name: str
    title: str
    source: str
    run: Callable[[Recipe], Iterable[Row]]
    quick: bool = True  # below ten seconds with kernels from the cache: part of the test command


@dataclass(frozen=True)
class Verified:
    """A row of a case with the wall time since the row before it."""

    case: str
    row: Row
    seconds: float

    def as_json(self) -> dict[str, Any]:
        """As plain objects."""
        return {"case": self.case, **self.row.as_json(), "seconds": round(self.seconds, 3)}


def _figure(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"


def relative(
    claim: str,
    *,
    expected: float,
    got: float,
    within: float | None = None,
    order: float | None = None,
) -> Row:
    """A row whose error is relative to the exact answer.

    >>> relative("pressure (GPa)", expected=225.22, got=224.1, within=0.015).verdict
    'PASS'
    >>> relative("pressure (GPa)", expected=225.22, got=math.nan, within=0.015).verdict
    'FAIL'
    """
    return Row(claim, expected, got, abs(got - expected) / abs(expected), within, order)


def absolute(
    claim: str,
    *,
    expected: float,
    got: float,
    within: float | None = None,
    order: float | None = None,
) -> Row:
    """A row whose error is in the unit of the answer."""
    return Row(claim, expected, got, abs(got - expected), within, order)


def at_most(claim: str, *, limit: float, got: float) -> Row:
    """A row that passes when a figure does not exceed a limit; the error is by how much it does.

    >>> at_most("drift", limit=0.01, got=0.02).verdict, at_most("drift", limit=0.01, got=math.nan).verdict
    ('FAIL', 'FAIL')
    """
    return Row(claim, f"at most {limit:g}", got, _excess(got - limit), 0.0)


def at_least(claim: str, *, limit: float, got: float) -> Row:
    """A row that passes when a figure does not fall below a limit; the error is by how much it does.

    >>> at_least("rebound", limit=0.93, got=0.97).verdict
    'PASS'
    """
    return Row(claim, f"at least {limit:g}", got, _excess(limit - got), 0.0)


def reported(claim: str, got: float, *, order: float | None = None) -> Row:
    """A figure that stands beside others: whatever it is, it must be one; not a finite number fails.

    >>> reported("scatter", 0.03).verdict, reported("scatter", math.nan).verdict
    ('REPORT', 'FAIL')
    """
    if math.isfinite(got):
        return Row(claim, "", got, math.nan, None, order)
    return Row(claim, "a number", got, math.nan, 0.0, order)


def _excess(value: float) -> float:
    return value if math.isnan(value) else max(value, 0.0)


def observed_order(errors: Iterable[float], *, ratio: float = 2.0) -> float:
    """Order of convergence between the two finest grids of a series, coarse to fine, each ``ratio`` times finer.

    >>> observed_order([0.16, 0.04, 0.01])
    2.0
    """
    coarse, fine = list(errors)[-2:]
    if not (coarse > 0.0 and fine > 0.0):
        return math.nan
    return math.log(coarse / fine) / math.log(ratio)


def names(*, quick: bool = False) -> list[str]:
    """All cases, or the quick ones, sorted."""
    return [name for name, case in entries(__name__, "CASE").items() if case.quick or not quick]


def load(name: str) -> Case:
    """The case of a name; raises InvalidInput with the nearest one."""
    known: Mapping[str, Case] = entries(__name__, "CASE")
    if name not in known:
        raise refusal("case", name, "a verification case", nearest_cure(name, known))
    return known[name]


def verify(chosen: Iterable[str], recipe: Recipe = DEFAULT) -> Iterator[Verified]:
    """Run cases one after the other; what the solver raises is a row that failed."""
    for name in chosen:
        case = load(name)
        begin = time.perf_counter()
        try:
            for row in case.run(recipe):
                now = time.perf_counter()
                yield Verified(name, row, now - begin)
                begin = now
        except WhippleError as error:
            row = Row(f"{case.title}: {error}", "no error", math.nan, math.nan, 0.0)
            yield Verified(name, row, time.perf_counter() - begin)
