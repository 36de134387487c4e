"""What guides a search: how likely the limit of an outcome lies below a value, before any run.

A feature guides the searches for an outcome of its own through the entry-point group ``whipple.studies.sweeps.guides``.
"""

from collections.abc import Callable
from dataclasses import dataclass

from solver.registry import entries
from studies.laws import Shot
from studies.sweeps.search import Chance


@dataclass(frozen=True)
class Guide:
    """The chance that a searched limit lies below a value of an axis."""

    name: str
    outcome: str  # of which the limit is searched
    axis: str
    chance: Callable[[Shot], Chance | None]  # None where it is not known


def guide_of(outcome: str, axis: str) -> Guide | None:
    """The guide of a search; None where there is none."""
    every: list[Guide] = [*entries(__name__, "GUIDE").values()]
    return next((guide for guide in every if (guide.outcome, guide.axis) == (outcome, axis)), None)
