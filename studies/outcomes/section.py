"""Outcomes of shots: what happened, or what leaves it open."""

from dataclasses import dataclass

from studies.outcomes.found import Share
from studies.reports.records import Place
from studies.reports.section import Part, Section, Source


@dataclass(frozen=True)
class ComputedWay:
    """What one way of computing a shot says."""

    model: Place  # the way, by axes of the sweep
    outcome: bool | None  # None: open
    says: bool | None  # what its grid says where flags leave that open
    flags: tuple[str, ...]  # that leave it open
    grids: str  # what its grids say together; empty of one grid
    found: Share | None  # of the perforated walls of published shots those that such simulations perforate


@dataclass(frozen=True)
class ShotOutcome:
    """The outcome of a shot, whichever way it is computed."""

    at: Place
    outcome: bool | None  # None where grids, flags or ways leave it open
    computed: tuple[ComputedWay, ...]  # those that have a run which ended


@dataclass(frozen=True)
class QuantityOutcomes:
    """An outcome at each shot."""

    quantity: str
    words: tuple[str, str]  # what false and true mean
    is_wall: bool  # whether published shots tell how many failures such simulations find
    shots: tuple[ShotOutcome, ...]


@dataclass(frozen=True)
class Outcomes:
    """All outcomes of a sweep."""

    quantities: tuple[QuantityOutcomes, ...]


def _part(source: Source) -> Part | None:
    from studies.outcomes.shots import outcomes_part

    return outcomes_part(source)


SECTION = Section(
    "outcomes",
    "Outcomes",
    14,
    Outcomes,
    _part,
    "studies.outcomes:section.html",
    appendix="studies.outcomes:appendix.html",
    rank=40,
)
