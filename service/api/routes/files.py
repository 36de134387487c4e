"""Cube and report of a sweep as files, and all of its files in one: bytes with a checksum, never opened here."""

import hashlib
import json
import re
from collections.abc import Iterator, Mapping
from types import MappingProxyType
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool
from zipstream import ZipStream

from service.api.conversions import LARGE, PARTIAL, PARTIAL_REPORT, Conversions, FileInputs, MadeFile
from service.api.dependencies import AppArtifacts, AppStore, SweepId
from service.api.downloads import Download, bring_back, media_type_of, send_file, send_made, serves
from service.api.errors import FileDamaged, NotReady
from service.api.routes import Routes
from service.api.schemas import REPORT_SCHEMA
from service.api.turns import WaitingThreads, in_waiting_thread, turn_of
from service.files.artifacts import FOR_PUBLICATIONS, Artifacts
from service.records.jobs import NotFound, Stored, SweepStatus
from service.store import Store
from studies.quantities.files import (
    ALL_RUNS_CSV,
    APPENDIX_HTML,
    ARCHIVE,
    CUBE,
    DIGESTS,
    REPORT_HTML,
    REPORT_JSON,
    RUNS_CSV,
    ZARR,
)

PIECE = 1 << 20  # bytes of a file that are read at once
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


@serves(
    router,
    f"/{ARCHIVE}",
    (ARCHIVE,),
    "Everything of a sweep that has ended in one file: its document, what it published, and the stored files of its "
    "runs in `runs/ID/`; `SHA256SUMS` has the digest of each (`sha256sum --check SHA256SUMS`)",
)
async def get_archive_zip(id: SweepId, request: Request, store: AppStore, artifacts: AppArtifacts) -> Response:
    threads: WaitingThreads = request.app.state.waiting_threads

    def archived() -> tuple[str, ZipStream]:
        sweep = store.sweeps.get(id)
        if not sweep.is_terminal:
            raise NotReady(f"the sweep is {_progress(sweep)}")
        document = json.dumps(store.sweeps.document(id), ensure_ascii=False, indent=1).encode()
        return sweep.name, _archive_of(artifacts, store.publications.archived(id), {"sweep.json": document})

    name, archive = await in_waiting_thread(request, archived)
    filename = f"{_plain(name)}-{ARCHIVE}"
    return StreamingResponse(
        threads.each(turn_of(request).caller, iter(archive)),
        media_type=media_type_of(ARCHIVE),
        headers={"Content-Length": str(len(archive)), "Content-Disposition": f'attachment; filename="{filename}"'},
    )


@serves(router, f"/{ZARR}", (ZARR,), "The cube as a Zarr store in a ZIP file; needs the extra `zarr` on the service")
async def get_cube_zarr(id: SweepId, request: Request, store: AppStore) -> Response:
    sweep, stored = await run_in_threadpool(store.sweeps.get_with_file, id, CUBE)
    if stored is None:
        raise _absent(sweep, CUBE)
    return await send_made(request, "zarr.zip", [stored], f"{_plain(sweep.name)}-{ZARR}", is_attachment=True)


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
        filename = f"{_plain(sweep.name)}-{name}"
        return await send_file(
            request, Download(artifacts.path(stored), filename, stored.sha256, is_attachment, headers, stored)
        )
    if partial is None:
        raise _absent(sweep, name)
    made = await _so_far(request, sweep, partial)
    if made.age is not None:
        headers = {**headers, "Age": str(round(made.age))}
    return await send_file(
        request, Download(made.path, f"{_plain(sweep.name)}-partial-{name}", made.sha256, is_attachment, headers)
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
            raise NotReady(f"the sweep is {_progress(sweep)}, and none of its runs has a result yet")
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
    return NotReady(f"the sweep is {_progress(sweep)}")


def _progress(sweep: SweepStatus) -> str:
    return f"{sweep.state}, {sweep.progress:.0%} done"


def _plain(name: str) -> str:
    """A sweep's name as part of a file name."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name)[:80].strip("-.") or "sweep"


def _archive_of(artifacts: Artifacts, files: Mapping[str, Stored], texts: Mapping[str, bytes]) -> ZipStream:
    """A ZIP file of stored files and texts by name: a piece of a file is in memory at a time.

    The files are stored as they are, most of them are compressed already, so that the length of the whole is known
    before. One of them has the digests of the others, as ``sha256sum --check`` reads them.

    Raises FileDamaged: before the first byte for a file that is missing or has another size, at its end for one with
    another digest, so that no damaged file is ever part of a whole archive.
    """
    lacking = [
        name for name, stored in files.items() if not (artifacts.is_there(stored) or artifacts.is_in_bucket(stored))
    ]
    if lacking:
        raise FileDamaged(
            f"{len(lacking)} files are lost or damaged, the first is {lacking[0]}; ask again later, or restore them"
        )
    digests = {name: stored.sha256 for name, stored in files.items()}
    digests |= {name: hashlib.sha256(text).hexdigest() for name, text in texts.items()}
    lines = "".join(f"{sha256}  {name}\n" for name, sha256 in sorted(digests.items()))
    archive = ZipStream(sized=True)
    for name, text in {**texts, DIGESTS: lines.encode()}.items():
        archive.add(text, name)
    for name, stored in files.items():
        archive.add(_content(artifacts, stored), name, size=stored.size)
    return archive


def _content(artifacts: Artifacts, stored: Stored) -> Iterator[bytes]:
    sha256 = hashlib.sha256()
    with artifacts.local(stored).open("rb") as file:
        while piece := file.read(PIECE):
            sha256.update(piece)
            yield piece
    if sha256.hexdigest() != stored.sha256:
        raise FileDamaged(f"{stored.name} is not the file that was registered")
