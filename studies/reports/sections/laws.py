"""Laws and measured shots beside the simulation."""

from dataclasses import dataclass

from studies.reports.records import Judgement, MatchedObservation, MeasuredShot, Mixed, Unchecked
from studies.reports.section import Part, Section, Source


@dataclass(frozen=True)
class Counted:
    """Why a law has no answer, or one outside of its range, with the number of such answers."""

    reason: str
    answers: int


@dataclass(frozen=True)
class LawSource:
    """A law with its equation and source."""

    name: str
    title: str
    quantity: str
    equation: str
    source: str
    range: str
    confidence: str
    scatter: float | None  # published, relative
    variants: tuple[str, ...]  # that it was evaluated with
    reasons: tuple[Counted, ...]


@dataclass(frozen=True)
class Laws:
    """How each law does, what was measured, and what was not checked."""

    judgements: tuple[Judgement, ...]
    shots: tuple[MeasuredShot, ...]  # that a point repeats
    own_shots: tuple[MatchedObservation, ...]  # with the simulation brought to their parameters
    unchecked: tuple[Unchecked, ...]
    mixed: tuple[Mixed, ...]
    sources: tuple[LawSource, ...]


def _part(source: Source) -> Part | None:
    from studies.reports.sections._laws import laws_of

    return laws_of(source)


SECTION = Section(
    "laws", "Laws", 20, Laws, _part, "sections/laws.html", "sections/laws_first.html", "sections/laws_appendix.html", 0
)
