"""The list of sweeps as people read it: what it shows of each, and which it shows in which order."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from pydantic import JsonValue

from service.records.jobs import SweepState, SweepStatus

PAGE = 50  # sweeps of a page, unless it is asked for another number
Column = Literal["submitted", "title", "scenario", "materials", "runs"]  # of a list, by which it can be in order


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """Which sweeps a list shows, and in which order.

    Each word of ``text`` is part of the title, name, scenario or a material of what is wanted, or it begins the id.
    """

    text: str = ""
    state: SweepState | None = None
    scenario: str = ""
    material: str = ""  # a part of the name of one
    owner: str | None = None
    order: Column = "submitted"
    ascending: bool = False
    first: int = 0
    limit: int = PAGE


@dataclass(frozen=True)
class LogbookEntry:
    """A sweep with what a list shows of it."""

    status: SweepStatus
    files: Sequence[str]  # names of the published ones
    materials: tuple[str, ...]
    axes: Mapping[str, JsonValue]  # as in its document
    document: Mapping[str, JsonValue] | None  # of one whose title another entry has, unless it is long


@dataclass(frozen=True)
class Logbook:
    """A part of the list of sweeps, and whether runs are begun."""

    entries: tuple[LogbookEntry, ...]
    has_more: bool
    paused: datetime | None  # since when no run is begun
    blocked_reason: str | None  # why nothing is begun although there is work
