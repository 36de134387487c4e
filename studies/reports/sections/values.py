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


def _part(source: Source) -> Part:
    from studies.cubes.points import axes_of, main_quantities
    from studies.cubes.variable import OUTCOMES
    from studies.reports.figures import figures
    from studies.reports.opening import computed_of, ends_of, headline, is_made_by_mesh, opening_of

    points, comparison = source.points, source.comparison
    names, ranges = [name for name in main_quantities(points) if OUTCOMES not in points[name].attrs], []
    for name in names:
        if computed := computed_of(points, name):
            low, high = ends_of(computed)
            unit = str(points[name].attrs["units"])
            ranges.append(Range(name, unit, low.value, low.bar, low.at, high.value, high.bar, high.at))
    counts = {name: int(is_made_by_mesh(points, name).sum()) for name in names}
    withheld = (Withheld(name, count, points.run_state.size) for name, count in counts.items() if count)
    opening = opening_of(points, comparison.judgements, comparison.shots)
    units = {name: points[name].attrs.get("units") for name in axes_of(points)}
    record = Values(tuple(ranges), tuple(withheld))
    if opening is None:
        return Part(record)
    return Part(record, figures(comparison, [told.quantity for told in opening.quantities]), headline(opening, units))


SECTION = Section(
    "values", "Values", 30, Values, _part, "sections/values.html", "sections/values_first.html", "", 90, True
)
