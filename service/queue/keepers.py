"""Keepers of a bucket's files: features, by the entry-point group ``whipple.service.queue.keepers``."""

from dataclasses import dataclass
from typing import Protocol

from service.files.artifacts import Artifacts
from service.files.disk_space import Space
from service.queue.clock_watch import ClockWatch
from service.queue.scrubbing import Scrubber
from service.settings import Settings
from service.store import Store
from solver.registry import points


@dataclass(frozen=True)
class Kept:
    """What a keeper works on."""

    settings: Settings
    store: Store
    artifacts: Artifacts
    space: Space
    clock: ClockWatch
    scrubber: Scrubber


class Keeper(Protocol):
    """Keeps the files of a bucket, beside the leader's ticks: it may be slow, or away."""

    def __init__(self, kept: Kept):
        pass

    def step(self) -> None:
        """Do a bounded part of the work, or begin to; the scrubber's step too."""


def keepers(kept: Kept) -> list[Keeper]:
    """Those of the features, where files are in a bucket; else none."""
    classes: list[type[Keeper]] = [point.load() for point in points("service.queue.keepers")]
    return [keeper(kept) for keeper in classes] if kept.artifacts.bucket is not None else []
