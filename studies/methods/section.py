"""What the method does to an answer: points that several methods computed, beside the bars of both."""

from dataclasses import dataclass

from studies.reports.records import Place
from studies.reports.section import Part, Section, Source


@dataclass(frozen=True)
class ByMethod:
    """A point by another method and by the first one; SI."""

    at: Place
    method: str
    reference: float | None  # by the first method
    reference_bar: float | None
    value: float | None
    bar: float | None
    difference: float | None
    joint: float | None  # root of the sum of the squares of both bars; None where a mesh error is unknown
    relative: float | None  # over the reference


@dataclass(frozen=True)
class ComparedMethod:
    """A quantity by another method than the first, over all points."""

    method: str
    points: int  # that both measured
    smallest: float | None  # relative difference
    largest: float | None
    judged: int  # with the bars of both
    beyond: int  # of these, more than both bars together


@dataclass(frozen=True)
class QuantityByMethod:
    """A quantity by each method."""

    quantity: str
    unit: str
    methods: tuple[ComparedMethod, ...]
    rows: tuple[ByMethod, ...]


@dataclass(frozen=True)
class Cost:
    """How many times as long the runs of a method took as those of the first, by the clock."""

    method: str
    times: float


@dataclass(frozen=True)
class Methods:
    """All methods of a sweep beside the first."""

    first: str
    quantities: tuple[QuantityByMethod, ...]
    costs: tuple[Cost, ...]


def _part(source: Source) -> Part | None:
    from studies.methods.differences import methods_of

    return methods_of(source)


SECTION = Section(
    "methods", "Methods", 25, Methods, _part, "studies.methods:section.html", "studies.methods:first.html", "", 30
)
