"""Cube and report of a sweep as files: bytes with a checksum, never opened here."""

import re
from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from starlette.concurrency import run_in_threadpool

from service.api.dependencies import SweepId
from service.api.downloads import Download, send_file, serves
from service.api.errors import NotReady
from service.api.routes import Routes
from service.api.schemas import REPORT_SCHEMA
from service.files.artifacts import Artifacts
from service.records.jobs import NotFound, SweepStatus
from service.store import Store
from solver.registry import points
from studies.quantities.files import ALL_RUNS_CSV, APPENDIX_HTML, CUBE, REPORT_HTML, REPORT_JSON, RUNS_CSV

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
    return await _send(request, id, CUBE, partial, is_attachment=True)


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
    return await _send(request, id, REPORT_HTML, partial, headers=REPORT_HEADERS)


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


async def _send(
    request: Request,
    id: str,
    name: str,
    partial: bool = False,
    *,
    is_attachment: bool = False,
    headers: Mapping[str, str] = MappingProxyType({}),
) -> Response:
    """Send a file of a sweep that has ended; before, that of the results so far if it is ``partial``.

    A feature makes that; it offers a function by entry points ``whipple.service.api.routes.files``.
    """
    store: Store = request.app.state.store
    artifacts: Artifacts = request.app.state.artifacts
    sweep, stored = await run_in_threadpool(store.sweeps.get_with_file, id, name)
    if stored is not None:
        filename = f"{plain(sweep.name)}-{name}"
        return await send_file(
            request, Download(artifacts.path(stored), filename, stored.sha256, is_attachment, headers, stored)
        )
    for point in points("service.api.routes.files") if partial else ():
        so_far: Download = await point.load()(request, sweep, name, is_attachment=is_attachment, headers=headers)
        return await send_file(request, so_far)
    raise absent(sweep, name)


def absent(sweep: SweepStatus, name: str) -> Exception:
    """The error for a file that a sweep has not published."""
    if sweep.is_terminal:
        return NotFound("file", f"{sweep.id}/{name}", NOT_PUBLISHED)
    return NotReady(f"the sweep is {progress_of(sweep)}")


def progress_of(sweep: SweepStatus) -> str:
    return f"{sweep.state}, {sweep.progress:.0%} done"


def plain(name: str) -> str:
    """A sweep's name as part of a file name."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name)[:80].strip("-.") or "sweep"
