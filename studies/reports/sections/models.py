"""What material data and models leave open of each quantity."""

from collections.abc import Mapping
from dataclasses import dataclass

from studies.reports.section import Part, Section, Source


@dataclass(frozen=True)
class Side:
    """How far failures that count move a value to one side."""

    share: float | None  # of the value
    failure: str


@dataclass(frozen=True)
class ModelPart:
    """What the models leave open of a quantity at some runs."""

    quantity: str
    statement: str  # with its source, or why nothing is assessed
    contributions: Mapping[str, float | None]  # relative standard uncertainties
    lower: Side | None
    upper: Side | None
    thrown_out: tuple[str, ...]  # failures that do not count
    distance: float | None  # largest factor by which the runs are outside of where it was measured
    runs: int


@dataclass(frozen=True)
class Models:
    """The model part of each quantity."""

    parts: tuple[ModelPart, ...]


def _part(source: Source) -> Part | None:
    from studies.reports.sections._accuracy import models_of

    return models_of(source)


SECTION = Section("models", "Uncertainty of the models", 60, Models, _part, appendix="sections/models_appendix.html")
