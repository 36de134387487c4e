"""Tables of shots that features have besides the published ones here.

A feature lists one through the entry-point group ``whipple.studies.observations.tables``.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from solver.registry import entries


@dataclass(frozen=True)
class ShotTable:
    """A table of shots with a page of its own."""

    name: str
    remark: str
    address: str  # of its page
    count: Callable[[], int]


def further_tables() -> Sequence[ShotTable]:
    """The tables of features."""
    return tuple(entries(__name__, "TABLE").values())
