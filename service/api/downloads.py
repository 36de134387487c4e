"""Endpoints that respond with a file, described alike in OpenAPI.

The strong entity tag of a file is its SHA-256; the file is read to compare it once, and again when its size or a time
of it changes. Starlette's ``FileResponse`` implements Range and If-Range; If-None-Match (304) and If-Match (412) are
implemented here.
"""

import base64
import logging
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path, PurePath

from fastapi import APIRouter, Request, Response
from fastapi.responses import FileResponse, RedirectResponse
from starlette.concurrency import run_in_threadpool

from service.api.errors import FileDamaged, PreconditionFailed
from service.api.turns import in_waiting_thread
from service.files.artifacts import Artifacts, known_digest
from service.files.stores import FilesAway
from service.queue.retry import make_again
from service.records.jobs import NotFound, Stored

UNKNOWN_TYPE = "application/octet-stream"
MEDIA_TYPES = {
    ".nc": "application/x-netcdf",
    ".csv": "text/csv; charset=utf-8",
    ".html": "text/html; charset=utf-8",
    ".json": "application/json",
    ".txt": "text/plain; charset=utf-8",
    ".zip": "application/zip",
    ".gif": "image/gif",
}
CONDITIONS = frozenset({"range", "if-range", "if-match", "if-none-match"})  # on digests, which a bucket does not know
log = logging.getLogger(__name__)

BINARY = {"schema": {"type": "string", "format": "binary"}}
TEXT = {"schema": {"type": "string"}}
ANY_OBJECT = {"type": "object"}

Endpoint = Callable[..., Awaitable[Response]]


@dataclass(frozen=True)
class Download:
    """A complete file that may be downloaded."""

    path: Path
    filename: str  # plain: letters, digits, "._-"
    sha256: str
    is_attachment: bool = False
    headers: Mapping[str, str] = field(default_factory=dict)
    registered: Stored | None = None  # None: made on request


def media_type_of(name: str) -> str:
    """The media type of a file, by its suffix.

    >>> media_type_of("cube.nc"), media_type_of("state.npz")
    ('application/x-netcdf', 'application/octet-stream')
    """
    return MEDIA_TYPES.get(PurePath(name).suffix, UNKNOWN_TYPE)


async def bring_back(request: Request, *files: Stored) -> None:
    """Bring files back from the bucket that the disk lacks, if there is one; raises FilesAway."""
    artifacts: Artifacts = request.app.state.artifacts
    if artifacts.bucket is not None:
        await in_waiting_thread(request, lambda: [artifacts.local(file) for file in files])


async def send_file(request: Request, download: Download) -> Response:
    """The response to a GET of a file; raises NotFound, FileDamaged, PreconditionFailed, FilesAway."""
    artifacts: Artifacts = request.app.state.artifacts
    if artifacts.bucket is not None and download.registered is not None:
        link = await in_waiting_thread(request, _link, request, artifacts, download)
        if link is not None:
            return RedirectResponse(link, headers={"ETag": f'"{download.sha256}"', "Cache-Control": "no-store"})
        await bring_back(request, download.registered)
    response = await run_in_threadpool(_whole_response, request, download)
    if response is None:
        cure = await in_waiting_thread(request, _cure, request, download)
        raise FileDamaged(f"{download.filename} is not the file that was registered, and is not sent; {cure}")
    return response


def _whole_response(request: Request, download: Download) -> Response | None:
    """The response with a file as it was registered; None for a damaged one."""
    try:
        status = download.path.stat()
        found = known_digest(download.path)
    except FileNotFoundError:  # perhaps the whole disk is away: the slow check of all files knows
        raise NotFound("file", download.filename) from None
    if found != download.sha256:
        return None
    tag = f'"{download.sha256}"'
    digest = base64.b64encode(bytes.fromhex(download.sha256)).decode()
    headers = {
        **download.headers,
        "Cache-Control": "private, no-cache",  # a retry replaces the file at this address
        "ETag": tag,
        "Repr-Digest": f"sha-256=:{digest}:",
    }
    # Strong comparison, RFC 9110 section 13.1.1.
    if not {"*", tag} & _tags(request.headers.get("if-match", "*")):
        raise PreconditionFailed("the file differs from the one in If-Match; repeat the request without If-Match")
    # Weak comparison, section 13.1.2.
    if {"*", tag} & {other.removeprefix("W/") for other in _tags(request.headers.get("if-none-match", ""))}:
        return Response(status_code=304, headers=headers)
    return FileResponse(
        download.path,
        headers=headers,
        media_type=media_type_of(download.filename),
        filename=download.filename,
        stat_result=status,
        content_disposition_type="attachment" if download.is_attachment else "inline",
    )


def _cure(request: Request, download: Download) -> str:
    """What becomes of a damaged file, which is made again if it may be."""
    registered = download.registered
    if registered is not None and make_again(request.app.state.store, registered) is None:
        log.error(
            "%s is damaged; too many are to be made again by themselves: `whipple doctor --forget-lost`", download.path
        )
        return "too many files are damaged for them to be made again: restore it, or `whipple doctor --forget-lost`"
    return (
        "it is made again where a sweep needs it, which may take as long as its runs: ask for it later, or restore it "
        "from a backup"
    )


def _link(request: Request, artifacts: Artifacts, download: Download) -> str | None:
    """A link to the bucket, where the setting asks for one, of a whole file that no browser shows.

    The digest is compared by who follows it: it is in the entity tag of the redirect. The door of the own user leads to
    this service alone.
    """
    seconds, stored, bucket = request.app.state.settings.artifacts_links, download.registered, artifacts.bucket
    if not seconds or bucket is None or stored is None or not download.is_attachment:
        return None
    is_own_door = (request.scope.get("server") or ("", 0))[1] is None  # a path has no port
    if CONDITIONS & set(request.headers) or is_own_door or request.scope.get("is_head"):
        return None
    with suppress(FilesAway):  # the disk may have it
        return bucket.link(stored.path, seconds) if artifacts.is_in_bucket(stored) else None
    return None


def _tags(header: str) -> set[str]:
    return {tag.strip() for tag in header.split(",")}


def serves(
    router: APIRouter, path: str, names: tuple[str, ...], description: str, *, schema: Mapping[str, str] = ANY_OBJECT
) -> Callable[[Endpoint], Endpoint]:
    """Add an endpoint for a file that is like one of ``names``; ``schema`` is that of JSON."""
    types = [media_type_of(name).partition(";")[0] for name in names]
    json = {"schema": {**schema}}
    content = {name: json if name.endswith("json") else TEXT if "text" in name else BINARY for name in types}
    partial = {"description": "The part that `Range` requests", "content": dict.fromkeys(content, BINARY)}

    return router.get(
        path,
        description=f"{description}.",
        response_class=Response,
        responses={
            200: {"description": description, "content": content},
            206: partial,
            304: {"description": "Unchanged"},
        },
    )
