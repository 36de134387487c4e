"""The record of a compared figure: the expected and the computed value, the error and its tolerance.

A tolerance is set from the numerics' order or from what the answer is needed for; a comparison without one is reported.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Literal, Self

Figure = float | str


@dataclass(frozen=True)
class Comparison:
    """A compared figure: its claim, the expected and the computed value, and whether it passes."""

    claim: str  # the compared quantity, with its unit: "plateau pressure, Cu 6 km/s (GPa)"
    expected: Figure  # the published number, or the limit in words; "" where there is none
    got: Figure  # computed now
    passed: bool | None = None  # None: reported, not gated
    error: float = math.nan  # relative to the answer, or in the unit of the claim; NaN: none
    tolerance: float | None = None  # tolerance of the error
    bar: float | None = None  # numerical uncertainty of what was computed, in its unit
    others: Mapping[str, Figure] = field(default_factory=dict)  # what others computed, by their names

    @property
    def verdict(self) -> Literal["REPORT", "PASS", "FAIL"]:
        """How it ended."""
        if self.passed is None:
            return "REPORT"
        return "PASS" if self.passed else "FAIL"

    def ungated(self, limit: float) -> Self:
        """As a report, whose claim says whether the gate would hold."""
        claim = f"{self.claim}, {'holds' if self.passed else 'misses'} {limit:g}"
        return replace(self, claim=claim, passed=None, tolerance=None)

    def __str__(self) -> str:
        return " | ".join(
            (
                f"{self.verdict:6}",
                self.claim,
                "reported" if self.expected == "" else f"expected {_line(self.expected)}",
                f"got {_line(self.got)}" + ("" if self.bar is None else f" ± {self.bar:.3g}"),
                *([] if math.isnan(self.error) else [f"error {self.error:.3g}"]),
                *([] if self.tolerance is None else [f"tolerance {self.tolerance:g}"]),
                *(f"{name} {_line(value)}" for name, value in self.others.items()),
            )
        )

    def as_json(self) -> dict[str, Figure | dict[str, Figure | None] | None]:
        """As plain objects; a number that is not finite is null."""
        plain = {each.name: _plain(getattr(self, each.name)) for each in fields(self) if each.name != "others"}
        return {
            **plain,
            "others": {name: _plain(value) for name, value in self.others.items()},
            "verdict": self.verdict,
        }


def _plain(value: Figure | None) -> Figure | None:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _line(value: Figure) -> str:
    """A value as one line, numbers with six digits."""
    return " ".join((f"{value:.6g}" if isinstance(value, float) else str(value)).split())


def relative(claim: str, *, expected: float, got: float, within: float | None = None) -> Comparison:
    """A comparison whose error is relative to the published number."""
    return _within(claim, expected, got, abs(got - expected) / abs(expected), within)


def absolute(claim: str, *, expected: float, got: float, within: float | None = None) -> Comparison:
    """A comparison whose error is in the unit of the published number."""
    return _within(claim, expected, got, abs(got - expected), within)


def at_most(claim: str, *, limit: float, got: float) -> Comparison:
    """A comparison that passes when a figure does not exceed a limit; the error is the excess."""
    return _within(claim, f"at most {limit:g}", got, got - limit if math.isnan(got) else max(got - limit, 0.0), 0.0)


def reported(claim: str, got: float) -> Comparison:
    """A figure without an expected value; it fails where it is not a finite number."""
    return Comparison(claim, "", got) if math.isfinite(got) else Comparison(claim, "a number", got, passed=False)


def _within(claim: str, expected: Figure, got: float, error: float, tolerance: float | None) -> Comparison:
    """A comparison that passes when its error is within its tolerance; not a number fails."""
    return Comparison(claim, expected, got, None if tolerance is None else bool(error <= tolerance), error, tolerance)
