"""What endpoints are given: the parts of the app, and the sweep document in the body."""

from typing import Annotated, Any

from fastapi import Depends, Request

from service.documents import read_json, read_yaml
from service.errors import BodyTooLarge, UnsupportedMediaType
from service.settings import Settings
from service.store import Store
from studies.sweep import Sweep, SweepLimits

LONGEST_BODY = 4 * 1024 * 1024  # bytes; ten thousand observations take about one million
READERS = {
    "application/json": read_json,
    "application/yaml": read_yaml,
    "application/x-yaml": read_yaml,
    "text/yaml": read_yaml,
}


def the_store(request: Request) -> Store:
    """The store that the app was built with."""
    return request.app.state.store


def the_settings(request: Request) -> Settings:
    """The settings that the app was built with."""
    return request.app.state.settings


async def the_body(request: Request) -> bytes:
    """The body, up to the limit. (The limit of the framework answers in plain text, so it is counted here.)"""
    declared = request.headers.get("content-length", "")
    body = bytearray()
    if declared.isdigit() and int(declared) > LONGEST_BODY:
        raise BodyTooLarge(f"{declared} bytes; at most {LONGEST_BODY}")
    async for chunk in request.stream():
        body += chunk
        if len(body) > LONGEST_BODY:
            raise BodyTooLarge(f"more than {LONGEST_BODY} bytes")
    return bytes(body)


def the_sweep(
    request: Request,
    body: Annotated[bytes, Depends(the_body)],
    settings: Annotated[Settings, Depends(the_settings)],
) -> Sweep:
    """The sweep that the body describes, checked in full; raises InvalidInput with every finding."""
    request.state.document = document = _document(request, body)
    return Sweep.parse(document, SweepLimits(max_runs=settings.max_runs))


def _document(request: Request, body: bytes) -> Any:
    media_type = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    reader = READERS.get(media_type)
    if reader is None:
        raise UnsupportedMediaType(f"{media_type!r}; send one of: {', '.join(READERS)}")
    return reader(body)


StoreGiven = Annotated[Store, Depends(the_store)]
SettingsGiven = Annotated[Settings, Depends(the_settings)]
SweepGiven = Annotated[Sweep, Depends(the_sweep)]
