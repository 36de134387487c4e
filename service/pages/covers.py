"""The cover of a sweep's report, as pages show it."""

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated

from fastapi import Depends, Request
from starlette.concurrency import run_in_threadpool

from service.api.access import Reader
from service.api.dependencies import AppStore, SweepId
from service.api.downloads import bring_back
from service.files.artifacts import Artifacts
from service.records.jobs import Stored, SweepStatus
from studies.quantities.files import COVER
from studies.reports.cover import Cover, read_cover


@dataclass(frozen=True)
class ShownCover:
    """The cover of a sweep's report, and the file of it."""

    cover: Cover
    file: Path

    def address(self, status: SweepStatus, name: str) -> str:
        """The address of a drawing; empty where there is none."""
        return cover_address(status, name) if name in self.cover.drawings else ""


def cover_address(status: SweepStatus, name: str) -> str:
    """The address of a drawing of a cover, another one after each publication."""
    return f"/sweeps/{status.id}/cover/{name}?at={status.finished.timestamp() if status.finished else 0:.0f}"


async def cover_of(request: Request, id: SweepId, _: Reader, store: AppStore) -> ShownCover | None:
    """The cover of a sweep, brought back from a bucket; None without one."""
    _status, stored = await run_in_threadpool(store.sweeps.get_with_file, id, COVER)
    if stored is None:
        return None
    await bring_back(request, stored)
    artifacts: Artifacts = request.app.state.artifacts
    if not artifacts.may_be_shown(stored):
        return None
    return ShownCover(await run_in_threadpool(_read_cover, artifacts, stored), artifacts.path(stored))


@lru_cache(maxsize=256)
def _read_cover(artifacts: Artifacts, stored: Stored) -> Cover:
    return read_cover(artifacts.path(stored))


CoverOfSweep = Annotated[ShownCover | None, Depends(cover_of)]
