"""Tables of shots that features have besides the published ones here.

A feature lists one through the entry-point group ``whipple.studies.observations.tables``.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from solver.registry import entries

Point = tuple[float, float]


@dataclass(frozen=True)
class ShotTable:
    """A table of shots with a page of its own."""

    name: str
    remark: str
    address: str  # of its page
    count: Callable[[], int]
    # What its picture shows, and the points (speed, m/s, and a size, m) of shots that failed and that held.
    points: "Callable[[], tuple[str, Sequence[Point], Sequence[Point]]] | None" = None


def further_tables() -> Sequence[ShotTable]:
    """The tables of features."""
    return tuple(entries(__name__, "TABLE").values())
