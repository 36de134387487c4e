"""A verdict as it is stated: records that hold words and the numbers behind them."""

from dataclasses import asdict, dataclass
from typing import Any

from studies.cubes.points import Place
from studies.reports.verdict.bands import BandValue
from studies.reports.verdict.evidence import Reference, StatedWord
from studies.reports.verdict.trends import Exponent, Trend


@dataclass(frozen=True)
class StatedBand:
    """A band with the words for it; shares are over the reference."""

    word: StatedWord
    where: str  # "from 6 km/s"
    says: str  # "numerically to 6 %"
    abscissa: str
    values: tuple[BandValue, ...]  # of the abscissa, SI
    slices: tuple[Place, ...]  # values of the other axes; empty for all
    points: int
    judged: int
    smallest: float | None  # residual
    largest: float | None
    limit: float  # largest difference or joint uncertainty of the judged points
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
    says: str  # "numerically", "under-predicts"
    untested: str  # "mesh error unknown"; empty where the uncertainty is a test


@dataclass(frozen=True)
class LawVerdict:
    """The verdict on one law, or on the simulation, against one reference."""

    subject: str
    title: str
    reference: Reference
    caveat: str  # "recalled, cross-checked"; empty where the law was read in a source
    no_range: str  # "no range stated by its source"; empty where one is
    other_material: bool  # whether every point is outside its range because of the material of the target
    bands: tuple[StatedBand, ...]
    points: int
    judged: int  # points inside the range with a value and without a flag
    close_points: frozenset[int]  # numbers of the points at which it is close
    smallest: float | None  # residual over the reference, of the judged points
    largest: float | None
    average: float | None  # None where it would hide what the residuals do
    trend: Trend | None  # where there is no average
    exponents: tuple[Exponent, ...]
    tested: int  # judged points whose uncertainty is a test
    inside: int  # of these, points with the difference inside the joint uncertainty
    each: tuple[StatedPoint, ...]
    sentence: str = ""
    details: tuple[str, ...] = ()  # sentences on residuals, exponents and error bars

    @property
    def close(self) -> int:
        """Number of points at which it is close."""
        return len(self.close_points)


@dataclass(frozen=True)
class QuantityVerdict:
    """The verdict on all laws of one quantity."""

    quantity: str
    recommendation: str  # empty where no point judges anything
    sentences: tuple[str, ...]  # of it
    reason: str  # why no law is recommended; empty where one is
    laws: tuple[LawVerdict, ...]  # against observations first, and those that are close at most points
    unjudged: tuple[str, ...]  # sentences on the laws that no point can judge
    drawn: tuple[str, ...]  # sentences on the laws that enter no verdict
    flags: tuple[str, ...]  # sentences


@dataclass(frozen=True)
class Verdict:
    """The verdict on a sweep."""

    reason: str  # why there is none; empty where there is one
    summary: tuple[str, ...]  # the sentences that come first, or the reason alone
    quantities: tuple[QuantityVerdict, ...] = ()  # with a law or an observation; judged ones first
    without_recommendation: str = ""  # a sentence on all quantities without a law to recommend
    rests: str = ""  # what the judgement rests on
    bars: str = ""  # what the error bars hold
    shots: str = ""  # how whipple itself does beside published shots
    terms: tuple[tuple[str, str], ...] = ()  # each word with its definition

    def as_json(self) -> dict[str, Any]:
        """Plain objects for the report."""
        plain = asdict(self)
        for quantity in plain["quantities"]:
            for law in quantity["laws"]:
                law["close"] = len(law.pop("close_points"))
        return {**plain, "terms": [{"word": word, "meaning": text} for word, text in self.terms]}
