"""Cube and report as files, and parts of a cube: bytes with a checksum, never opened here.

The strong entity tag is the file's SHA-256, so a client that has the file is answered 304, and one
that has a part of it can ask for the rest (Range, If-Range).
"""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from fastapi import APIRouter, Query, Request, Response

from service.artifacts import Artifacts
from service.downloads import Offer, send
from service.errors import NotReady
from service.jobs import NotFound, SweepRow
from service.routes.given import ArtifactsGiven, SlicesGiven, StoreGiven, SweepId
from service.routes.serving import content_of, served_as, serves
from service.slices import Part, Slices
from service.store import Store
from studies.errors import Finding, InvalidInput
from studies.files import CUBE, PAGE, TWIN
from studies.nearest import nearest_cure, shown
from studies.variables import variable_name

router = APIRouter(prefix="/v1/sweeps/{id}", tags=["files"])

# The report brings its script along; the sandbox keeps that script away from this service.
REPORT_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; frame-ancestors 'none'; base-uri 'none'; "
    "sandbox allow-scripts allow-downloads allow-popups"
)
SLICE = "slice"
REFINEMENTS = ("cells_per_diameter", "offset", "run")  # dimensions that are no axis of a document
MOST_TEXTS = 200  # of a query
LONGEST_TEXT = 200  # characters
KNOWN = frozenset({"variable", "format", "partial"})  # of a query; what else is there names an axis
AT: dict[str, Any] = {
    "parameters": [
        {
            "name": "axes",
            "in": "query",
            "required": False,
            "style": "form",
            "explode": True,
            "schema": {"type": "object", "additionalProperties": {"type": "string"}},
            "description": "for each axis, by its name, a value (several: name it again) or a range: "
            "`speed=6 km/s`, `speed=2000..4000`; without a unit SI",
        }
    ]
}
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
    slices: SlicesGiven,
    partial: Partial = False,
) -> Response:
    cube = _cube(store, artifacts, slices, id, partial=partial)
    return send(request, Offer(cube.path, served_as(CUBE), cube.name, cube.sha256, attachment=True))


@serves(
    router,
    f"/{PAGE}",
    (PAGE,),
    "the report for people: one file that needs no network",
    operation_id="get_report_html",
)
def download_page(
    id: SweepId, request: Request, store: StoreGiven, artifacts: ArtifactsGiven
) -> Response:
    policy = {"Content-Security-Policy": REPORT_POLICY}
    return send(request, _published(store, artifacts, id, PAGE, headers=policy))


@serves(
    router,
    f"/{TWIN}",
    (TWIN,),
    "the report for programs: the same numbers",
    operation_id="get_report_json",
)
def download_twin(
    id: SweepId, request: Request, store: StoreGiven, artifacts: ArtifactsGiven
) -> Response:
    return send(request, _published(store, artifacts, id, TWIN))


@router.get(
    f"/{SLICE}",
    openapi_extra=AT,
    response_class=Response,
    responses={
        200: {
            "description": "the part that was asked for",
            "content": content_of("slice.json", "slice.nc"),
        },
        206: {"description": "the part of it that `Range` asks for"},
        304: {"description": "unchanged"},
    },
)
def show_slice(
    id: SweepId,
    request: Request,
    store: StoreGiven,
    artifacts: ArtifactsGiven,
    slices: SlicesGiven,
    variable: Annotated[
        list[str] | None, Query(description="of the cube; none: what was measured")
    ] = None,
    format: Annotated[str, Query(pattern="^(json|nc)$", description="`json` or `nc`")] = "json",
    partial: Partial = False,
) -> Response:
    """A part of the cube: some variables at some values of its axes, as JSON or NetCDF.

    What belongs to a variable, its uncertainty and flags and the state of the runs, comes along.
    """
    at = _at(request, axes=store.sweep_document(id).get("axes", {}))
    cube = _cube(store, artifacts, slices, id, partial=partial)
    file, digest = slices.part(cube.path, cube.sha256, Part(tuple(variable or ()), at, format))
    name = f"{cube.sweep}-{SLICE}.{format}"
    return send(request, Offer(file, served_as(name), name, digest, attachment=format == "nc"))


@dataclass(frozen=True)
class Cube:
    """A cube to be sent, whole or as far as it is."""

    sweep: str  # its name, plain
    path: Path
    sha256: str
    label: str  # which of the two it is

    @property
    def name(self) -> str:
        """What it is called where it is sent to."""
        return f"{self.sweep}-{self.label}"


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


def _cube(store: Store, artifacts: Artifacts, slices: Slices, id: str, *, partial: bool) -> Cube:
    """The cube of a sweep; on request one that is not complete."""
    sweep, stored = store.sweep_and_file(id, CUBE)
    if stored is not None:
        return Cube(_plain(sweep.name), artifacts.path(stored), stored.sha256, CUBE)
    if not partial:
        raise _missing(sweep, CUBE)
    document, outcomes = store.question(sweep.id)
    if not any(outcome.path for outcome in outcomes):
        raise NotReady(f"the sweep is {_how_far(sweep)}, and none of its runs has a result yet")
    state = f"{sweep.state}, {sum(outcome.path is not None for outcome in outcomes)}"
    state = f"{state} of {len(outcomes)} runs have a result"
    path, sha256 = slices.partial_cube(document, outcomes, artifacts.root, state)
    return Cube(_plain(sweep.name), path, sha256, f"partial-{CUBE}")


def _missing(sweep: SweepRow, name: str) -> Exception:
    """Why a file is not there: it never will be, or not yet."""
    if sweep.is_terminal:
        return NotFound("file", f"{sweep.id}/{name}")
    return NotReady(f"the sweep is {_how_far(sweep)}")


def _at(request: Request, axes: Any) -> dict[str, tuple[str, ...]]:
    """What a query asks of each axis; raises InvalidInput."""
    names = {variable_name(name) for name in (*axes, *REFINEMENTS)}
    at: dict[str, tuple[str, ...]] = {}
    for name, text in request.query_params.multi_items():
        if name in KNOWN:
            continue
        if variable_name(name) not in names:
            limit, cure = "an axis of this sweep", nearest_cure(name[:LONGEST_TEXT], names)
            raise InvalidInput([Finding(name[:LONGEST_TEXT], shown(text), limit, cure)])
        at[variable_name(name)] = (*at.get(variable_name(name), ()), text)
    texts = [text for given in at.values() for text in given]
    if len(texts) > MOST_TEXTS or any(len(text) > LONGEST_TEXT for text in texts):
        limit = f"at most {MOST_TEXTS} values of {LONGEST_TEXT} characters"
        raise InvalidInput([Finding("query", f"{len(texts)} values", limit, "name a range")])
    return at


def _how_far(sweep: SweepRow) -> str:
    return f"{sweep.state}, {sweep.progress:.0%} done"


def _plain(name: str) -> str:
    """A sweep's name as part of a file name."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name)[:80].strip("-.") or "sweep"
