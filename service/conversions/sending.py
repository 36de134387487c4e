"""Responses with files that are made when they are asked for."""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import Unpack

from fastapi import Request, Response

from service.api.downloads import Download, bring_back, send_file
from service.api.turns import turn_of
from service.conversions.conversions import Conversions, FileOptions
from service.records.jobs import Stored


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
