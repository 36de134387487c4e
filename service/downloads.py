"""Files as answers: strong tags, digests, parts, and what a caller has already is not sent again.

Of RFC 9110 this speaks If-Match, If-None-Match, Range with one part, and If-Range with a strong tag; a Range that
it does not understand, or that asks for several parts, is answered with the whole file, as that text
allows. A file is opened before the first byte of the answer, so that what is sent is what was announced
even if the file is replaced or goes on growing meanwhile.
"""

import base64
import os
import re
from collections.abc import AsyncIterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO

import anyio.to_thread
from fastapi import Request, Response
from fastapi.responses import StreamingResponse

from service.errors import Changed, NotSatisfiable
from service.jobs import NotFound

CHUNK = 1 << 18  # bytes read at once
ONE_PART = re.compile(r"bytes\s*=\s*(\d{0,18})\s*-\s*(\d{0,18})\s*", re.IGNORECASE)


@dataclass(frozen=True)
class Offer:
    """A file that somebody may have."""

    path: Path
    media_type: str
    filename: str  # plain: letters, digits, "._-"
    sha256: str | None = None  # None: it may still grow, so nothing is said of its content
    attachment: bool = False
    headers: Mapping[str, str] = field(default_factory=dict)

    @property
    def tag(self) -> str | None:
        """The strong entity tag: the digest of the content."""
        return None if self.sha256 is None else f'"{self.sha256}"'


def send(request: Request, offer: Offer) -> Response:
    """The answer to a GET or HEAD of a file; raises NotFound, NotSatisfiable, Changed."""
    headers = _headers(offer)
    if not _is_meant(request.headers.get("if-match"), offer.tag):
        raise Changed
    if offer.tag is not None and _has_it(request.headers.get("if-none-match", ""), offer.tag):
        return Response(status_code=304, headers=headers)
    try:
        file = offer.path.open("rb")
    except FileNotFoundError:
        raise NotFound("file", offer.filename) from None
    try:
        size = os.fstat(file.fileno()).st_size
        part = _part(request, offer.tag, size)
        begin, end = part or (0, size)
        headers["Content-Length"] = str(end - begin)
        if part is not None:
            headers["Content-Range"] = f"bytes {begin}-{end - 1}/{size}"
        status = 200 if part is None else 206
        if request.method == "HEAD":
            file.close()
            return Response(None, status, headers, offer.media_type)
        return StreamingResponse(_bytes(file, begin, end), status, headers, offer.media_type)
    except BaseException:
        file.close()
        raise


def _headers(offer: Offer) -> dict[str, str]:
    disposition = "attachment" if offer.attachment else "inline"
    headers = {
        **offer.headers,
        "Accept-Ranges": "bytes",
        "Cache-Control": "private, no-cache",  # after a retry another file has this address
        "Content-Disposition": f'{disposition}; filename="{offer.filename}"',
    }
    if offer.sha256 is not None and offer.tag is not None:
        digest = base64.b64encode(bytes.fromhex(offer.sha256)).decode()
        headers |= {"ETag": offer.tag, "Repr-Digest": f"sha-256=:{digest}:"}
    return headers


def _is_meant(if_match: str | None, tag: str | None) -> bool:
    """Whether the file is one that the caller wants; strong comparison, RFC 9110 section 13.1.1."""
    return if_match is None or bool({"*", tag} & {one.strip() for one in if_match.split(",")})


def _has_it(if_none_match: str, tag: str) -> bool:
    """Whether the caller's copy is this one; weak comparison, RFC 9110 section 13.1.2."""
    known = {one.strip().removeprefix("W/") for one in if_none_match.split(",")}
    return bool(known & {tag, "*"})


def _part(request: Request, tag: str | None, size: int) -> tuple[int, int] | None:
    """Begin and end of the part that is asked for; None: the whole file."""
    if_range = request.headers.get("if-range")
    if if_range is not None and if_range != tag:
        return None
    return part_of(request.headers.get("range", ""), size)


def part_of(wanted: str, size: int) -> tuple[int, int] | None:
    """What a Range header asks of a file of ``size`` bytes, as begin and end; None: the whole file.

    Raises NotSatisfiable.

    >>> part_of("bytes=2-4", 10), part_of("bytes=7-", 10), part_of("bytes=-3", 10), part_of("", 10)
    ((2, 5), (7, 10), (7, 10), None)
    """
    match = ONE_PART.fullmatch(wanted)
    if match is None or not any(match.groups()):
        return None
    first, last = match.groups()
    if not first:
        begin, end = max(0, size - int(last)), size
    else:
        begin, end = int(first), min(size, int(last) + 1) if last else size
        if last and int(last) < begin:
            return None  # no part at all: as if nothing had been asked (section 14.1.1)
    if begin >= end:
        raise NotSatisfiable(size)
    return begin, end


async def _bytes(file: BinaryIO, begin: int, end: int) -> AsyncIterator[bytes]:
    """The bytes of a file between two places, read in threads."""
    with file:
        await anyio.to_thread.run_sync(file.seek, begin)
        while begin < end:
            chunk = await anyio.to_thread.run_sync(file.read, min(CHUNK, end - begin))
            if not chunk:
                return  # it was cut short; the length that was announced tells the caller
            begin += len(chunk)
            yield chunk
