"""Cube and report of a sweep as files: bytes with a checksum, never opened here."""

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from starlette.concurrency import run_in_threadpool

from service.api.conversions import LARGE, PARTIAL, PARTIAL_REPORT, Conversions, FileInputs, MadeFile
from service.api.dependencies import AppStore, SweepId
from service.api.downloads import Download, bring_back, send_file, send_made, serves
from service.api.errors import NotReady
from service.api.routes import Routes
from service.api.schemas import REPORT_SCHEMA
from service.api.turns import turn_of
from service.files.artifacts import FOR_PUBLICATIONS, Artifacts
from service.records.jobs import NotFound, SweepStatus
from service.store import Store
from studies.quantities.files import ALL_RUNS_CSV, APPENDIX_HTML, CUBE, REPORT_HTML, REPORT_JSON, RUNS_CSV, ZARR

NOT_PUBLISHED = "nothing was published; `whipple retry` publishes it again"

router = APIRouter(prefix="/v1/sweeps/{id}", tags=["results"])
ROUTES = Routes("files", 20, guarded=(router,))

SoFar = Annotated[bool, Query(description="Return the file of the results so far while the sweep is unfinished")]

# The report contains its script; the sandbox isolates that script from this service. The page of its sweep frames it.
# What it links opens in a window outside the sandbox: from inside it no cookie would be sent, and no page would open.
REPORT_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; frame-ancestors 'self'; base-uri 'none'; "
    "sandbox allow-scripts allow-downloads allow-popups allow-popups-to-escape-sandbox"
)
REPORT_HEADERS = {"Content-Security-Policy": REPORT_POLICY, "X-Frame-Options": "SAMEORIGIN"}


@serves(
    router,
    f"/{CUBE}",
    (CUBE,),
    "The labelled result of the sweep (NetCDF-4). With `partial=true` also before the sweep ends: unfinished runs "
    "are NaN, `run_state` marks them, and the attribute `sweep_state` describes the progress",
)
async def get_cube_nc(id: SweepId, request: Request, partial: SoFar = False) -> Response:
    return await _send(request, id, CUBE, PARTIAL if partial else None, is_attachment=True)


@serves(
    router,
    f"/{RUNS_CSV}",
    (RUNS_CSV,),
    "One row a run: axes, main quantities with uncertainty and flags, state, in SI with units in the header. With "
    "`all=true` also all other results, parameters and the audit",
)
async def get_runs_csv(
    id: SweepId,
    request: Request,
    every_column: Annotated[bool, Query(alias="all", description="Return every column")] = False,
) -> Response:
    return await _send(request, id, ALL_RUNS_CSV if every_column else RUNS_CSV, is_attachment=True)


@serves(
    router,
    f"/{REPORT_HTML}",
    (REPORT_HTML,),
    "The report for people: one file that needs no network. With `partial=true` also before the sweep ends: of the "
    "results so far, without pictures",
)
async def get_report_html(id: SweepId, request: Request, partial: SoFar = False) -> Response:
    return await _send(request, id, REPORT_HTML, PARTIAL_REPORT if partial else None, headers=REPORT_HEADERS)


@serves(
    router,
    f"/{APPENDIX_HTML}",
    (APPENDIX_HTML,),
    "What the report leaves out: every run, the audit and all quantities, in one file that needs no network",
)
async def get_appendix_html(id: SweepId, request: Request) -> Response:
    return await _send(request, id, APPENDIX_HTML, headers=REPORT_HEADERS)


@serves(
    router,
    f"/{REPORT_JSON}",
    (REPORT_JSON,),
    "The report for programs: the same numbers. The schema is that of sweeps that this version publishes",
    schema=REPORT_SCHEMA,
)
async def get_report_json(id: SweepId, request: Request) -> Response:
    return await _send(request, id, REPORT_JSON)


@serves(router, f"/{ZARR}", (ZARR,), "The cube as a Zarr store in a ZIP file; needs the extra `zarr` on the service")
async def get_cube_zarr(id: SweepId, request: Request, store: AppStore) -> Response:
    sweep, stored = await run_in_threadpool(store.sweeps.get_with_file, id, CUBE)
    if stored is None:
        raise _absent(sweep, CUBE)
    return await send_made(request, "zarr.zip", [stored], f"{plain(sweep.name)}-{ZARR}", is_attachment=True)


async def _send(
    request: Request,
    id: str,
    name: str,
    partial: str | None = None,
    *,
    is_attachment: bool = False,
    headers: Mapping[str, str] = MappingProxyType({}),
) -> Response:
    """Send a file of a sweep that has ended; before, that of the results so far of the kind ``partial``."""
    store: Store = request.app.state.store
    artifacts: Artifacts = request.app.state.artifacts
    sweep, stored = await run_in_threadpool(store.sweeps.get_with_file, id, name)
    if stored is not None:
        filename = f"{plain(sweep.name)}-{name}"
        return await send_file(
            request, Download(artifacts.path(stored), filename, stored.sha256, is_attachment, headers, stored)
        )
    if partial is None:
        raise _absent(sweep, name)
    made = await _so_far(request, sweep, partial)
    if made.age is not None:
        headers = {**headers, "Age": str(round(made.age))}
    return await send_file(
        request, Download(made.path, f"{plain(sweep.name)}-partial-{name}", made.sha256, is_attachment, headers)
    )


async def _so_far(request: Request, sweep: SweepStatus, kind: str) -> MadeFile:
    """The cube or the report of the results so far; raises NotReady, Busy, ConversionFailed."""
    store: Store = request.app.state.store
    artifacts: Artifacts = request.app.state.artifacts
    conversions: Conversions = request.app.state.conversions

    def gather() -> FileInputs:
        document, outcomes = store.publications.inputs(sweep.id)
        results = sum(outcome.path is not None for outcome in outcomes)
        if not results:
            raise NotReady(f"the sweep is {progress_of(sweep)}, and none of its runs has a result yet")
        runs = [outcome.as_json(artifacts.root) for outcome in outcomes]
        state = f"{sweep.state}, {results} of {len(outcomes)} runs have a result"
        return {"document": document, "outcomes": runs, "state": state}

    if artifacts.bucket is not None:
        archived = await run_in_threadpool(store.publications.archived, sweep.id)
        await bring_back(request, *(stored for stored in archived.values() if stored.name in FOR_PUBLICATIONS))
    is_large = sweep.planned > LARGE
    return await conversions.partial(kind, sweep.id, gather, turn_of(request), is_large=is_large)


def _absent(sweep: SweepStatus, name: str) -> Exception:
    """The error for a file that a sweep has not published."""
    if sweep.is_terminal:
        return NotFound("file", f"{sweep.id}/{name}", NOT_PUBLISHED)
    return NotReady(f"the sweep is {progress_of(sweep)}")


def progress_of(sweep: SweepStatus) -> str:
    return f"{sweep.state}, {sweep.progress:.0%} done"


def plain(name: str) -> str:
    """A sweep's name as part of a file name."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name)[:80].strip("-.") or "sweep"
