"""The documentation of the API; open to callers without a key, because problem documents point there."""

import json
import threading
from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

from fastapi import APIRouter, FastAPI, Request, Response
from fastapi.responses import HTMLResponse
from markupsafe import escape

from service.api.errors import INTERNAL_ERROR, PROBLEMS
from service.api.pages.rendering import rendered

router = APIRouter(include_in_schema=False, default_response_class=HTMLResponse)

ADDRESS = "\0"  # occurs in no text of the page
BUILDING = threading.Lock()  # ``cache`` alone lets every thread that finds nothing build the page


@router.get("/docs")
def show_documentation(request: Request) -> str:
    """Every operation of the API with parameters, examples and responses."""
    address = escape(str(request.base_url).rstrip("/"))
    with BUILDING:
        page = _documentation(request.app)
    return page.replace(ADDRESS, address)


@router.get("/openapi.json", response_class=Response)
def show_openapi(request: Request) -> Response:
    """The OpenAPI document."""
    with BUILDING:
        document = _openapi(request.app)
    return Response(document, media_type="application/json")


@cache
def _documentation(app: FastAPI) -> str:
    """The page with ``ADDRESS`` in place of that of the service; rendering it takes 50 ms (2026-11)."""
    return rendered(
        "docs.html",
        operations=list(_operations(app.openapi())),
        problems=[*PROBLEMS.values(), INTERNAL_ERROR],
        address=ADDRESS,
    )


@cache
def _openapi(app: FastAPI) -> bytes:
    return json.dumps(app.openapi(), ensure_ascii=False).encode()


def _operations(document: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            yield {**operation, "path": path, "method": method.upper()}
