"""The values of a sweep: smallest and largest, figures of each quantity, and what a report opens with."""

from dataclasses import dataclass

from studies.reports.records import Place
from studies.reports.section import Part, Section, Source


@dataclass(frozen=True)
class Range:
    """Smallest and largest value of a main quantity, with bars and places; SI."""

    quantity: str
    unit: str
    smallest: float
    smallest_uncertainty: float | None
    smallest_at: Place
    largest: float
    largest_uncertainty: float | None
    largest_at: Place


@dataclass(frozen=True)
class Withheld:
    """A quantity with values that are no answer, because the mesh alone made what they count."""

    quantity: str
    points: int
    of: int


@dataclass(frozen=True)
class Values:
    """The values of the main quantities."""

    ranges: tuple[Range, ...]
    withheld: tuple[Withheld, ...]


def _part(source: Source) -> Part | None:
    from studies.reports.sections._values import values_of

    return values_of(source)


SECTION = Section(
    "values", "Values", 30, Values, _part, "sections/values.html", "sections/values_first.html", "", 90, True
)
