"""The cube as Zarr, and files of the results so far."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Unpack

from fastapi import APIRouter, FastAPI, Request, Response
from starlette.concurrency import run_in_threadpool

from service.api.dependencies import AppStore, SweepId
from service.api.downloads import Download, bring_back, send_file, serves
from service.api.errors import NotReady
from service.api.routes import Routes
from service.api.routes.files import absent, plain, progress_of
from service.api.turns import turn_of
from service.conversions.conversions import (
    LARGE,
    PARTIAL,
    PARTIAL_REPORT,
    Conversions,
    FileInputs,
    FileOptions,
    MadeFile,
)
from service.files.artifacts import FOR_PUBLICATIONS, Artifacts
from service.records.jobs import Stored, SweepStatus
from service.store import Store
from studies.quantities.files import CUBE, REPORT_HTML, ZARR

CACHE = "cache"  # folder of files that are made when they are asked for, in the data directory
KINDS = {CUBE: PARTIAL, REPORT_HTML: PARTIAL_REPORT}

router = APIRouter(prefix="/v1/sweeps/{id}", tags=["results"])


def _prepare(service: FastAPI) -> None:
    """Let a service have the cache of what it makes."""
    service.state.conversions = Conversions(service.state.settings.data / CACHE)


ROUTES = Routes("conversions", 22, guarded=(router,), prepare=_prepare)


@serves(router, f"/{ZARR}", (ZARR,), "The cube as a Zarr store in a ZIP file; needs the extra `zarr` on the service")
async def get_cube_zarr(id: SweepId, request: Request, store: AppStore) -> Response:
    sweep, stored = await run_in_threadpool(store.sweeps.get_with_file, id, CUBE)
    if stored is None:
        raise absent(sweep, CUBE)
    return await send_made(request, "zarr.zip", [stored], f"{plain(sweep.name)}-{ZARR}", is_attachment=True)


async def send_made(
    request: Request,
    kind: str,
    sources: Sequence[Stored],
    filename: str,
    *,
    is_attachment: bool = False,
    headers: Mapping[str, str] = MappingProxyType({}),
    **options: Unpack[FileOptions],
) -> Response:
    """The response with a file of a kind (``conversions.makers``) that is made from stored files."""
    conversions: Conversions = request.app.state.conversions
    await bring_back(request, *sources)
    made = await conversions.file(kind, sources, request.app.state.artifacts, turn_of(request), **options)
    return await send_file(request, Download(made.path, filename, made.sha256, is_attachment, headers))


async def so_far(
    request: Request, sweep: SweepStatus, name: str, *, is_attachment: bool, headers: Mapping[str, str]
) -> Download:
    """The cube or the report of the results so far; raises NotReady, Busy, ConversionFailed."""
    made = await _made(request, sweep, KINDS[name])
    if made.age is not None:
        headers = {**headers, "Age": str(round(made.age))}
    return Download(made.path, f"{plain(sweep.name)}-partial-{name}", made.sha256, is_attachment, headers)


async def _made(request: Request, sweep: SweepStatus, kind: str) -> MadeFile:
    """The file of a kind, which a child process makes."""
    store: Store = request.app.state.store
    artifacts: Artifacts = request.app.state.artifacts
    conversions: Conversions = request.app.state.conversions

    def gather() -> FileInputs:
        document, outcomes = store.publications.inputs(sweep.id, artifacts.root)
        results = sum(outcome["path"] is not None for outcome in outcomes)
        if not results:
            raise NotReady(f"the sweep is {progress_of(sweep)}, and none of its runs has a result yet")
        state = f"{sweep.state}, {results} of {len(outcomes)} runs have a result"
        return {"document": document, "outcomes": outcomes, "state": state}

    if artifacts.bucket is not None:
        archived = await run_in_threadpool(store.publications.archived, sweep.id)
        await bring_back(request, *(stored for stored in archived.values() if stored.name in FOR_PUBLICATIONS))
    is_large = sweep.planned > LARGE
    return await conversions.partial(kind, sweep.id, gather, turn_of(request), is_large=is_large)
