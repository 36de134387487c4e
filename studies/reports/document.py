"""The head of a report's document: what stands beside its sections. Nothing heavy is imported."""

from dataclasses import dataclass

from studies.reports.figure import Figure


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
