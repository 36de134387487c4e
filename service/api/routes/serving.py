"""Endpoints that answer with a file: GET and HEAD, described alike."""

from collections.abc import Callable
from pathlib import PurePath
from typing import Any

from fastapi import APIRouter, Response

BYTES = "application/octet-stream"
TYPES = {
    ".nc": "application/x-netcdf",
    ".html": "text/html; charset=utf-8",
    ".json": "application/json",
    ".txt": "text/plain; charset=utf-8",
}
BINARY = {"schema": {"type": "string", "format": "binary"}}
TEXT = {"schema": {"type": "string"}}
JSON = {"schema": {"type": "object"}}

Endpoint = Callable[..., Response]


def served_as(name: str) -> str:
    """The media type of a file, by the end of its name.

    >>> served_as("cube.nc"), served_as("state.npz")
    ('application/x-netcdf', 'application/octet-stream')
    """
    return TYPES.get(PurePath(name).suffix, BYTES)


def content_of(*names: str) -> dict[str, Any]:
    """What an answer holds that is one of these files, as OpenAPI describes it.

    >>> content_of("cube.nc")
    {'application/x-netcdf': {'schema': {'type': 'string', 'format': 'binary'}}}
    """
    types = [served_as(name).partition(";")[0] for name in names]
    return {
        one: JSON if one.endswith("json") else TEXT if "text" in one else BINARY for one in types
    }


def serves(
    router: APIRouter, path: str, names: tuple[str, ...], description: str, **more: Any
) -> Callable[[Endpoint], Endpoint]:
    """Add an endpoint that answers GET and HEAD of a file that is like one of ``names``."""
    content = content_of(*names)
    part = dict.fromkeys(content, BINARY)
    partial = {"description": "the part that `Range` asks for", "content": part}

    def add(endpoint: Endpoint) -> Endpoint:
        for method in ("GET", "HEAD"):
            router.add_api_route(
                path,
                endpoint,
                methods=[method],
                description=f"{description[0].upper()}{description[1:]}.",
                response_class=Response,
                responses={
                    200: {"description": description, "content": content},
                    206: partial,
                    304: {"description": "unchanged"},
                },
                include_in_schema=method == "GET",
                **more,
            )
        return endpoint

    return add
