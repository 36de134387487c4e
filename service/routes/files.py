"""Cube and report as files: bytes with a checksum, never opened here.

The strong entity tag is the file's SHA-256, so a client that has the file is answered 304, and one
that has a part of it can ask for the rest (Range, If-Range).
"""

import base64
import re
from pathlib import Path

from fastapi import APIRouter, Request, Response
from fastapi.responses import FileResponse

from service.artifacts import Artifacts
from service.errors import NotReady
from service.jobs import NotFound, Stored, SweepRow
from service.routes.given import SettingsGiven, StoreGiven
from service.schemas import FILES
from service.settings import Settings
from service.store import Store

router = APIRouter(prefix="/v1/sweeps/{id}", tags=["files"])

# The report brings its script along; the sandbox keeps that script away from this service.
REPORT_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; font-src data:; frame-ancestors 'none'; base-uri 'none'; "
    "sandbox allow-scripts allow-downloads allow-popups"
)


def _serve(name: str, description: str) -> None:
    """Add the endpoint of one file."""

    def download(id: str, request: Request, store: StoreGiven, settings: SettingsGiven) -> Response:
        sweep = store.sweep(id)
        return _response(request, sweep, name, _path(store, settings, sweep, name))

    content = {FILES[name].partition(";")[0]: {"schema": {"type": "string", "format": "binary"}}}
    for method in ("GET", "HEAD"):
        router.add_api_route(
            f"/{name}",
            download,
            methods=[method],
            operation_id=f"{method.lower()}_{name.replace('.', '_')}",
            description=f"{description[0].upper()}{description[1:]}.",
            response_class=Response,
            responses={
                200: {"description": description, "content": content},
                304: {"description": "unchanged"},
            },
            include_in_schema=method == "GET",
        )


_serve("cube.nc", "the labelled result of the sweep (NetCDF-4)")
_serve("report.html", "the report for people: one file that needs no network")
_serve("report.json", "the report for programs: the same numbers")


def _path(store: Store, settings: Settings, sweep: SweepRow, name: str) -> tuple[Stored, Path]:
    try:
        stored = store.artifact(sweep.id, name)
    except NotFound:
        if sweep.is_terminal:
            raise
        raise NotReady(f"the sweep is {sweep.state}, {sweep.progress:.0%} done") from None
    path = Artifacts(settings.data).path(stored)
    if not path.is_file():
        raise NotFound("file", f"{sweep.id}/{name}")
    return stored, path


def _response(request: Request, sweep: SweepRow, name: str, file: tuple[Stored, Path]) -> Response:
    stored, path = file
    headers = _headers(stored, name)
    if _has_it(request.headers.get("if-none-match", ""), headers["ETag"]):
        return Response(status_code=304, headers=headers)
    return FileResponse(
        path,
        headers=headers,
        media_type=FILES[name],
        filename=f"{_plain(sweep.name)}-{name}",
        content_disposition_type="attachment" if name == "cube.nc" else "inline",
    )


def _headers(stored: Stored, name: str) -> dict[str, str]:
    digest = base64.b64encode(bytes.fromhex(stored.sha256)).decode()
    headers = {
        "ETag": f'"{stored.sha256}"',
        "Repr-Digest": f"sha-256=:{digest}:",
        "Cache-Control": "private, no-cache",  # after a retry another file has this address
    }
    if name == "report.html":
        headers["Content-Security-Policy"] = REPORT_POLICY
    return headers


def _has_it(if_none_match: str, etag: str) -> bool:
    """Whether the caller's copy is this one; weak comparison, RFC 9110 section 13.1.2."""
    known = {tag.strip().removeprefix("W/") for tag in if_none_match.split(",")}
    return bool(known & {etag, "*"})


def _plain(name: str) -> str:
    """A sweep's name as part of a file name."""
    return re.sub(r"[^A-Za-z0-9._-]+", "-", name)[:80].strip("-.") or "sweep"
