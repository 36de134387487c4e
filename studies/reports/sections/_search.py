"""Computes the section of a search from the limits of its cube."""

from studies.cubes import limits
from studies.cubes.points import axes_of, plain
from studies.cubes.reading import finite
from studies.reports.section import Part, Source
from studies.reports.sections.search import FoundLimit, FoundLimits
from studies.reports.wording import text_template, worded


def search_of(source: Source) -> Part | None:
    """The section; None of a sweep without a search."""
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
    return Part(record, opening=headline(record))


def headline(search: FoundLimits) -> str:
    """The limits in words."""
    return worded(text_template("search.txt"), search=search)
