"""The limits that a sweep searched for."""

from dataclasses import dataclass

from studies.reports.records import Place
from studies.reports.section import Part, Section, Source
from studies.reports.wording import text_template, worded


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
    """None of a sweep without a search."""
    from studies.cubes import limits
    from studies.cubes.points import axes_of, plain
    from studies.cubes.reading import finite

    dataset = source.dataset
    if not limits.LIMIT.is_in(dataset):
        return None
    about = dataset.limit.attrs
    others = [name for name in axes_of(dataset) if f"limit_{name}" in dataset]
    found = (
        FoundLimit(
            at={name: plain(dataset[f"limit_{name}"].values[place]) for name in others},
            limit=finite(float(dataset.limit.values[place])),
            lower=finite(float(dataset.limit_lower.values[place])),
            upper=finite(float(dataset.limit_upper.values[place])),
            runs=int(dataset.limit_runs.values[place]),
            verdict=limits.VERDICTS[int(dataset.limit_verdict.values[place])].value,
            reason=str(dataset.limit_reason.values[place]),
        )
        for place in range(dataset.sizes[limits.SEARCH])
    )
    record = FoundLimits(str(about["axis"]), str(about["limit_of"]), str(about["units"]), tuple(found))
    return Part(record, opening=worded(text_template("search.txt"), search=record))


APPENDIX = "sections/search_appendix.html"
SECTION = Section("search", "Limits", 12, FoundLimits, _part, "sections/search.html", appendix=APPENDIX, rank=20)
