"""A verdict as it is stated: records that hold words and the numbers behind them."""

from dataclasses import asdict, dataclass
from typing import Any

from studies.cubes.points import Place
from studies.reports.verdict.bands import BandValue
from studies.reports.verdict.evidence import Hanging, Reference, StatedWord
from studies.reports.verdict.trends import Exponent, Trend


@dataclass(frozen=True)
class StatedBand:
    """A band with the words for it; shares are over the reference."""

    word: StatedWord
    where: str  # "from 6 km/s"
    says: str  # "meets the simulation: 1 % low to 2 % high, ±7 %"
    abscissa: str
    values: tuple[BandValue, ...]  # of the abscissa, SI
    slices: tuple[Place, ...]  # values of the other axes; empty for all
    points: int
    judged: int
    smallest: float | None  # residual
    largest: float | None
    uncertainty: float | None  # largest joint uncertainty of the judged points; None where none is judged
    beyond: int  # judged points with a difference beyond the joint uncertainty
    untested: int  # judged points at which error bars are no test
    unjudged: tuple[str, ...]  # why points of the band are not judged


@dataclass(frozen=True)
class StatedPoint:
    """A law beside its reference at one point; None where there is no number."""

    at: Place
    predicted: float | None
    reference: float | None
    difference: float | None  # over the reference
    word: StatedWord
    says: str  # "meets the simulation", "too low"
    untested: str  # "mesh error unknown"; empty where the uncertainty is a test
    hangs_on: tuple[Hanging, ...] = ()  # failures that alone decide whether it agrees


@dataclass(frozen=True)
class LawVerdict:
    """The verdict on one law, or on the simulation, against one reference."""

    subject: str
    title: str
    reference: Reference
    caveat: str  # what was not checked of it; empty where the law was read in a source
    no_range: str  # "no range stated by its source"; empty where one is
    other_material: bool  # whether every point is outside its range because of the material of the target
    bands: tuple[StatedBand, ...]
    points: int
    judged: int  # points inside the range with a value and without a flag
    smallest: float | None  # residual over the reference, of the judged points
    largest: float | None
    average: float | None  # None where it would hide what the residuals do
    trend: Trend | None  # where there is no average
    exponents: tuple[Exponent, ...]
    tested: int  # judged points whose uncertainty is a test
    inside: int  # of these, points with the difference inside the joint uncertainty
    each: tuple[StatedPoint, ...]
    details: tuple[str, ...] = ()  # sentences on residuals, exponents and error bars


@dataclass(frozen=True)
class NumberRow:
    """A law of the table beside the headline, with its numbers over the reference."""

    law: str
    where: str
    smallest: float
    largest: float
    bar: float | None  # largest joint uncertainty; None where none is a test
    points: int
    rejecting: int
    tested: int
    difference: str  # "8 % low to 2 % high"
    uncertainty: str  # "±9 %", or "mesh error unknown"
    against: str
    verdict: str


@dataclass(frozen=True)
class QuantityVerdict:
    """The verdict on all laws of one quantity."""

    quantity: str
    headline: str  # empty where no point judges a law
    rows: tuple[NumberRow, ...]  # the numbers behind it
    laws: tuple[LawVerdict, ...]  # against observations first, in the order of the headline
    unjudged: tuple[str, ...]  # sentences on the laws that no point can judge
    drawn: tuple[str, ...]  # sentences on the laws that enter no verdict


@dataclass(frozen=True)
class Verdict:
    """The verdict on a sweep."""

    headline: str  # empty where no law predicts anything
    quantities: tuple[QuantityVerdict, ...] = ()  # with a law or an observation; that of the headline first
    unchecked: tuple[str, ...] = ()  # sentences: what was not checked, and by whom
    shots: str = ""  # how whipple itself does beside published shots
    terms: tuple[tuple[str, str], ...] = ()  # each word with its definition

    def as_json(self) -> dict[str, Any]:
        """Plain objects for the report."""
        return {**asdict(self), "terms": [{"word": word, "meaning": text} for word, text in self.terms]}
