"""Files as responses: the strong entity tag is the SHA-256; Starlette's ``FileResponse`` answers Range and If-Range.

If-None-Match is answered 304 and If-Match 412 here, because ``FileResponse`` does neither.
"""

import base64
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from fastapi import Request, Response
from fastapi.responses import FileResponse

from service.api.errors import Changed
from service.records.jobs import NotFound


@dataclass(frozen=True)
class Offer:
    """A complete file that may be downloaded."""

    path: Path
    media_type: str
    filename: str  # plain: letters, digits, "._-"
    sha256: str
    attachment: bool = False
    headers: Mapping[str, str] = field(default_factory=dict)


def send(request: Request, offer: Offer) -> Response:
    """The response to a GET or HEAD of a file; raises NotFound, Changed."""
    tag = f'"{offer.sha256}"'
    digest = base64.b64encode(bytes.fromhex(offer.sha256)).decode()
    headers = {
        **offer.headers,
        "Cache-Control": "private, no-cache",  # after a retry another file has this address
        "ETag": tag,
        "Repr-Digest": f"sha-256=:{digest}:",
    }
    # Strong comparison, RFC 9110 section 13.1.1.
    if not {"*", tag} & _tags(request.headers.get("if-match", "*")):
        raise Changed
    # Weak comparison, section 13.1.2.
    if {"*", tag} & {
        one.removeprefix("W/") for one in _tags(request.headers.get("if-none-match", ""))
    }:
        return Response(status_code=304, headers=headers)
    try:
        status = offer.path.stat()
    except FileNotFoundError:
        raise NotFound("file", offer.filename) from None
    return FileResponse(
        offer.path,
        headers=headers,
        media_type=offer.media_type,
        filename=offer.filename,
        stat_result=status,
        content_disposition_type="attachment" if offer.attachment else "inline",
    )


def _tags(header: str) -> set[str]:
    return {tag.strip() for tag in header.split(",")}
