"""Every run with its values, flags and audit: on the appendix."""

from collections.abc import Mapping
from dataclasses import dataclass

from studies.reports.records import Place
from studies.reports.section import Section, when_called


@dataclass(frozen=True)
class ListedRun:
    """A run with the values of its cell by the names of the cube's variables; SI."""

    number: int
    at: Place
    state: str
    id: str
    reason: str
    failure: str
    stop: str
    flags: tuple[str, ...]
    doubted: bool  # by a flag on the run or on a main quantity: drawn as an open mark
    values: Mapping[str, float | None]


@dataclass(frozen=True)
class Audited:
    """A number of the audit over all runs."""

    variable: str
    label: str
    meaning: str
    unit: str
    is_share: bool
    smallest: float
    median: float
    largest: float
    farthest_at: Place  # of the run that is farthest from zero
    limit: float | None
    over_limit: int | None


@dataclass(frozen=True)
class Runs:
    """All runs, and the range of each number of their audit."""

    runs: tuple[ListedRun, ...]
    audit: tuple[Audited, ...]


PART = when_called("studies.reports.sections._runs:runs_of")
SECTION = Section("runs", "Runs", 110, Runs, PART, appendix="sections/runs_appendix.html")
