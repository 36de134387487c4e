"""The head of a report's document, and the type of the whole. Nothing heavy is imported."""

from dataclasses import dataclass, make_dataclass

from pydantic import TypeAdapter

from studies.reports.figure import Figure
from studies.reports.section import Section


@dataclass(frozen=True)
class Axis:
    """An axis of a sweep, or one over which each point is refined."""

    name: str
    unit: str | None  # SI; None for text
    meaning: str
    values: tuple[float | str, ...]
    refines: bool


@dataclass(frozen=True)
class MeasuredQuantity:
    """A quantity that the runs measured."""

    name: str
    unit: str
    meaning: str
    main: bool  # no other reading of one


@dataclass(frozen=True)
class Head:
    """What a report says beside its sections."""

    report_version: int
    title: str
    scenario: str
    scenario_title: str
    headline: str
    opened_by: str  # name of the section that the headline is of
    axes: tuple[Axis, ...]  # of points
    coordinates: tuple[Axis, ...]  # of runs
    quantities: tuple[MeasuredQuantity, ...]
    figures: tuple[Figure, ...]


def schema_of_report(sections: tuple[Section, ...]) -> TypeAdapter[Head]:
    """The type of a report; the record of a section without anything to say is absent."""
    records = [(section.name, section.record | None, None) for section in sections]
    return TypeAdapter(
        make_dataclass("Report", records, bases=(Head,), namespace={"__doc__": Head.__doc__}, frozen=True)
    )
