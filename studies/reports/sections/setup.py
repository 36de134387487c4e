"""The set-up of the runs: materials, shared parameters, cells, and doubts about them."""

from dataclasses import dataclass

from pydantic import JsonValue

from studies.reports.section import Section, when_called


@dataclass(frozen=True)
class Fixed:
    """A parameter that all runs share; SI."""

    name: str
    value: float | str
    unit: str | None
    meaning: str


@dataclass(frozen=True)
class StateCount:
    """The number of runs in a state."""

    state: str
    runs: int


@dataclass(frozen=True)
class Constant:
    """A number of a material with its source."""

    path: str
    value: float
    unit: str
    source: str
    confidence: str


@dataclass(frozen=True)
class MaterialUsed:
    """A material with all its constants."""

    name: str
    title: str
    numbers: tuple[Constant, ...]


@dataclass(frozen=True)
class SetUp:
    """What was computed."""

    runs: int
    states: tuple[StateCount, ...]
    flagged: int  # runs with a flag on themselves or on a main quantity
    flagged_elsewhere: int
    without_value: int  # that succeeded
    cells: tuple[float, float] | None  # fewest and most across the projectile's diameter; None where a run has none
    accuracy: str  # as the sweep asks for it; empty where it names a resolution
    asked: dict[str, JsonValue]  # what the sweep fixes, as it was written
    fixed: tuple[Fixed, ...]
    doubts: tuple[str, ...]  # about constants that the sweep changes
    materials: tuple[MaterialUsed, ...]


PART = when_called("studies.reports.sections._runs:setup_of")
SECTION = Section("setup", "Set-up", 40, SetUp, PART, "sections/setup.html", "", "sections/setup_appendix.html")
