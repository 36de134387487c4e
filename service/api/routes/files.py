"""Cube and report as files: bytes with a checksum, never opened here."""

import re
from typing import Annotated

from fastapi import APIRouter, Query, Request, Response

from service.api.downloads import Offer, send
from service.api.errors import NotReady
from service.api.partial_cubes import PartialCubes
from service.api.routes.given import ArtifactsGiven, PartialCubesGiven, StoreGiven, SweepId
from service.api.routes.serving import served_as, serves
from service.files.artifacts import Artifacts
from service.records.jobs import NotFound, SweepStatus
from service.store import Store
from studies.values.files import CUBE, REPORT_HTML, REPORT_JSON

router = APIRouter(prefix="/v1/sweeps/{id}", tags=["files"])

# The report brings its script along; the sandbox keeps that script away from this service.
REPORT_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; frame-ancestors 'none'; base-uri 'none'; "
    "sandbox allow-scripts allow-downloads allow-popups"
)
Partial = Annotated[
    bool, Query(description="of a sweep that has not ended: what there is until now")
]


@serves(
    router,
    f"/{CUBE}",
    (CUBE,),
    "the labelled result of the sweep (NetCDF-4); with `partial=true` also before its end: runs that "
    "have not ended are NaN, `run_state` says so, and the attribute `sweep_state` how far it was",
    operation_id="get_cube_nc",
)
def download_cube(
    id: SweepId,
    request: Request,
    store: StoreGiven,
    artifacts: ArtifactsGiven,
    cubes: PartialCubesGiven,
    partial: Partial = False,
) -> Response:
    return send(request, _cube(store, artifacts, cubes, id, partial=partial))


@serves(
    router,
    f"/{REPORT_HTML}",
    (REPORT_HTML,),
    "the report for people: one file that needs no network",
    operation_id="get_report_html",
)
def download_page(
    id: SweepId, request: Request, store: StoreGiven, artifacts: ArtifactsGiven
) -> Response:
    policy = {"Content-Security-Policy": REPORT_POLICY}
    return send(request, _published(store, artifacts, id, REPORT_HTML, headers=policy))


@serves(
    router,
    f"/{REPORT_JSON}",
    (REPORT_JSON,),
    "the report for programs: the same numbers",
    operation_id="get_report_json",
)
def download_twin(
    id: SweepId, request: Request, store: StoreGiven, artifacts: ArtifactsGiven
) -> Response:
    return send(request, _published(store, artifacts, id, REPORT_JSON))


def _published(
    store: Store, artifacts: Artifacts, id: str, name: str, headers: dict[str, str] | None = None
) -> Offer:
    """A file of a sweep that has ended; raises NotFound, NotReady."""
    sweep, stored = store.sweep_and_file(id, name)
    if stored is None:
        raise _missing(sweep, name)
    return Offer(
        path=artifacts.path(stored),
        media_type=served_as(name),
        filename=f"{_plain(sweep.name)}-{name}",
        sha256=stored.sha256,
        headers=headers or {},
    )


def _cube(
    store: Store, artifacts: Artifacts, cubes: PartialCubes, id: str, *, partial: bool
) -> Offer:
    """The cube of a sweep; with ``partial`` also of one that has not ended."""
    sweep, stored = store.sweep_and_file(id, CUBE)
    if stored is not None:
        path, sha256, name = artifacts.path(stored), stored.sha256, CUBE
    elif not partial:
        raise _missing(sweep, CUBE)
    else:
        document, outcomes = store.publication_inputs(sweep.id)
        results = sum(outcome.path is not None for outcome in outcomes)
        if not results:
            raise NotReady(f"the sweep is {_how_far(sweep)}, and none of its runs has a result yet")
        state = f"{sweep.state}, {results} of {len(outcomes)} runs have a result"
        path, sha256 = cubes.file(document, outcomes, artifacts.root, state)
        name = f"partial-{CUBE}"
    return Offer(path, served_as(CUBE), f"{_plain(sweep.name)}-{name}", sha256, attachment=True)


def _missing(sweep: SweepStatus, name: str) -> Exception:
    """Why a file is not there: it never will be, or not yet."""
    if sweep.is_terminal:
        return NotFound("file", f"{sweep.id}/{name}")
    return NotReady(f"the sweep is {_how_far(sweep)}")


def _how_far(sweep: SweepStatus) -> str:
    return f"{sweep.state}, {sweep.progress:.0%} done"


def _plain(name: str) -> str:
    """A sweep's name as part of a file name."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name)[:80].strip("-.") or "sweep"
