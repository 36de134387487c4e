"""The limits that a sweep searched for."""

from dataclasses import dataclass

from studies.reports.records import Place
from studies.reports.section import Part, Section, Source


@dataclass(frozen=True)
class FoundLimit:
    """Where an outcome turns from false to true, at one point of the other axes; SI."""

    at: Place
    limit: float | None  # middle of the interval; None where the search found none
    lower: float | None  # highest value without
    upper: float | None  # lowest value with it
    runs: int
    verdict: str  # a word of studies.sweeps.search.SearchVerdict
    reason: str  # why there is no limit, or why its interval is wider than asked


@dataclass(frozen=True)
class FoundLimits:
    """All limits of a search."""

    axis: str
    of: str  # the outcome
    unit: str  # of the axis
    rows: tuple[FoundLimit, ...]


def _part(source: Source) -> Part | None:
    from studies.reports.sections._search import search_of

    return search_of(source)


APPENDIX = "sections/search_appendix.html"
SECTION = Section("search", "Limits", 12, FoundLimits, _part, "sections/search.html", appendix=APPENDIX, rank=20)
