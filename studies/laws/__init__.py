"""Published laws: a formula for something that is measured on a shot, with source, units and range.

How to add one: one file here, named after the law, that offers ``LAW``. Write the bare formula as a
public function on arrays in SI, with a doctest that reproduces a published number; then the ``Law``
around it: equation as published, source, the scatter that the source states, and a range whose limits say what is
checked and where it is stated; it is for compact projectiles unless it states another ``projectile``. Its
``confidence`` decides its use: a law that is recalled and unchecked, or a rule of thumb, is drawn and compared, and
enters no verdict, no recommendation and no average (``DRAWN_ONLY``).
``tests/contracts/test_laws.py`` finds the file; cube, report, API and form need no edit.

A law answers outside its range too, flagged with the reasons; where it is meaningless it answers
NaN with the reason. Its band is the smallest to the largest answer over its stated variants.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from solver.registry import entries
from solver.units import Dimensionless, Metre, MetrePerSecond, Radian
from studies.laws._range import NOT_FOUND, SPEED, THICKNESS_RATIO, Code, Limit, Range, RangeCode, RangeStatus, Reason
from studies.laws._shot import Shot
from studies.laws._words import in_words, limit_in_latex, limit_in_words, range_in_words, without_markup
from studies.laws.predicted import critical, unmeasured
from studies.laws.targets import shot_from, target_of
from studies.quantities.findings import nearest_cure, refusal
from studies.quantities.parameters import Plain

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = [
    "CAVEATS",
    "DRAWN_ONLY",
    "NOT_FOUND",
    "SPEED",
    "THICKNESS_RATIO",
    "Code",
    "Law",
    "LawValue",
    "Limit",
    "Range",
    "RangeCode",
    "RangeStatus",
    "Reason",
    "Shot",
    "answering",
    "critical",
    "in_words",
    "limit_in_latex",
    "limit_in_words",
    "load",
    "names",
    "range_in_words",
    "shot_from",
    "target_of",
    "unmeasured",
]

ONE_FORM = ("",)  # the variants of a law that leaves no constant open

# Confidence decides the use of a law: these words of studies.materials.CONFIDENCES keep it out of verdicts,
# recommendations and averages, so that it is compared and drawn alone; what is not known at all is no law here.
DRAWN_ONLY: Mapping[str, str] = {"memory": "recalled and unchecked", "indicative": "a rule of thumb or a limit"}
# What a catalogue says of a law besides its range.
DESCRIBED = (
    *("name", "title", "quantity", "equation", "latex", "source", "confidence", "use"),
    *("scatter", "size_exponent", "largest_obliquity"),
)
PRINTED = 0.005  # relative: tables print two to three digits
# What a verdict says was not checked of a law, and by whom.
CAVEATS: Mapping[str, str] = {
    "cross-checked": "the authors of whipple recalled the equation from memory and compared it with independent "
    "numbers; they did not read the paper"
}


@dataclass(frozen=True)
class LawValue:
    """The value of a law for one shot."""

    value: Metre  # or its power, of a volume; NaN where the law is meaningless
    in_range: bool  # within every limit that can be checked
    reasons: tuple[Reason, ...] = ()  # why it is out of range, or meaningless

    @property
    def status(self) -> RangeStatus:
        """How the answer stands to the range."""
        if any(reason.code is Code.FITTED for reason in self.reasons):
            return RangeStatus.FITTED
        if any(reason.code.is_other_material for reason in self.reasons):
            return RangeStatus.OTHER_MATERIAL
        if math.isnan(self.value):
            return RangeStatus.NO_ANSWER
        return RangeStatus.INSIDE if self.in_range else RangeStatus.OUTSIDE_RANGE


@dataclass(frozen=True)
class FittedShot:
    """A measured shot that a constant of a law was fitted to; the law predicts it by construction."""

    speed: MetrePerSecond
    projectile_diameter: Metre  # diameter of the sphere with the projectile's volume
    value: Metre  # or its power, of a volume: the measured one


@dataclass(frozen=True, kw_only=True)
class Law:
    """A published formula for a measured quantity."""

    name: str
    title: str
    quantity: str  # "hole_diameter": a measurement, or what ``predicted`` lists
    latex: str = ""  # the equation as published, with its units, for pages: formulas between dollar signs
    equation: str = ""  # the same as plain text; stated where ``latex`` has fractions or roots, or is empty
    source: str
    confidence: str  # how well equation and constants are known: a word of studies.materials.CONFIDENCES
    range: Range
    # Relative standard deviation of the measured values about the law, as its source states it, with the place at the
    # line; None: not published.
    scatter: Dimensionless | None = None
    fitted_to: Sequence[FittedShot] = ()  # measured shots that say nothing about the law
    dimension: int = 1  # power of a length that the quantity is: 3 of a volume
    # Exponent of the value as a power of the size of the whole shot: 1 by geometric similarity, which matter without
    # rate effects keeps; None: the value is no such power.
    size_exponent: Dimensionless | None = 1.0
    largest_obliquity: Radian = 0.0  # 0: for normal impact
    # Value over the power ``dimension`` of the projectile's diameter, of a shot and a variant: a number.
    ratio: "Callable[[Shot, str], float | NDArray]"
    variants: Callable[[Shot], Sequence[str]] = lambda shot: ONE_FORM
    meaningless: Callable[[Shot, str], Reason | None] = lambda shot, variant: None  # why it has no answer
    # For laws of holes that fall below D/d = 1 in slow shots or thin plates: there they mean nothing.
    wider_than_projectile: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "equation", self.equation or without_markup(self.latex))

    def evaluate(self, shot: Shot, variant: str = "") -> LawValue:
        """The law's answer for one shot, with one of its variants."""
        reason = self.meaningless(shot, variant)
        if reason:
            return LawValue(math.nan, False, (reason,))
        ratio = float(self.ratio(shot, variant))
        if self.wider_than_projectile and ratio < 1.0:  # NaN is for the range to explain
            return LawValue(math.nan, False, (Reason(Code.NARROWER_THAN_PROJECTILE, "D/d", ratio, low=1.0),))
        value = ratio * shot.projectile_diameter**self.dimension
        reasons = self.range.reasons(shot)
        if shot.obliquity > self.largest_obliquity:
            high = self.largest_obliquity
            reasons = (*reasons, Reason(Code.OBLIQUITY, "theta", shot.obliquity, high=high, unit="rad"))
        return LawValue(value, not reasons, reasons)

    def is_fitted_to(self, shot: Shot, value: float) -> bool:
        """Whether a measured shot is, to the digits that tables print, one that a constant was fitted to."""
        return any(
            math.isclose(shot.speed, fitted.speed, rel_tol=PRINTED)
            and math.isclose(shot.projectile_diameter, fitted.projectile_diameter, rel_tol=PRINTED)
            and math.isclose(value, fitted.value, rel_tol=PRINTED)
            for fitted in self.fitted_to
        )

    def band(self, shot: Shot) -> tuple[float, float]:
        """Smallest and largest answer over the stated variants; NaN where there is none."""
        values = [self.evaluate(shot, variant).value for variant in self.variants(shot)]
        finite = [value for value in values if not math.isnan(value)]
        return (min(finite), max(finite)) if finite else (math.nan, math.nan)

    @property
    def use(self) -> str:
        """What its confidence allows: "verdict", or "drawn only" with the reason."""
        reason = DRAWN_ONLY.get(self.confidence)
        return f"drawn only ({reason})" if reason else "verdict"

    def describe(self) -> dict[str, Plain]:
        """The law as plain values, for a catalogue."""
        plain = {name: getattr(self, name) for name in DESCRIBED}
        return {**plain, "range": [_plain(limit) for limit in self.range.every]}


def _plain(limit: Limit) -> dict[str, Plain]:
    """A limit as plain values, for a catalogue; None for a bound that is none."""
    bounds = {name: getattr(limit, name) for name in ("low", "high")}
    return {
        "words": limit_in_words(limit),
        **{name: bound if math.isfinite(bound) else None for name, bound in bounds.items()},
        **{name: getattr(limit, name) for name in ("code", "symbol", "unit", "names", "source", "machine_checked")},
    }


def without_hardness(shot: Shot, variant: str) -> Reason | None:
    """For the laws with the Brinell hardness of the target: the reason where the material states none."""
    if not math.isnan(shot.brinell_hardness):
        return None
    return Reason(Code.NO_HARDNESS, found={"target": shot.target.name})


def names() -> list[str]:
    """All laws, sorted."""
    return list(entries(__name__, "LAW"))


def load(name: str) -> Law:
    """The law of a name; raises InvalidInput with the nearest one."""
    laws: Mapping[str, Law] = entries(__name__, "LAW")
    if name not in laws:
        raise refusal("law", name, "a law that ships", nearest_cure(name, laws))
    return laws[name]


def answering(quantity: str) -> list[Law]:
    """The laws for one measured quantity, in the order of their names."""
    return [law for law in map(load, names()) if law.quantity == quantity]
