"""The OpenAPI document: open to callers without a key, as it names no sweep."""

from functools import cache

from fastapi import APIRouter, FastAPI, Request
from fastapi.responses import JSONResponse
from pydantic import JsonValue

from service.api.routes import Routes
from service.openapi.schemas import component_schemas

router = APIRouter(include_in_schema=False)

TAGS = [  # the parts of the documentation, in the order of work; each route has one of these names
    {
        "name": "submit",
        "description": "A sweep document goes in; the response has its id and address. Examples use a document in "
        "`sweep.json`, such as one of those below, and ids in `$SWEEP` and `$RUN`.",
    },
    {"name": "watch", "description": "See how far a sweep is, change its priority, stop it, or try again."},
    {"name": "results", "description": "Cube, table and report of a sweep, and everything of it in one file."},
    {"name": "runs", "description": "One simulation each: its parameters, its log, its files, its film."},
    {"name": "catalogue", "description": "What a sweep may ask for, and what laws say without a run."},
    {
        "name": "keys",
        "description": "Requests from other machines need a key. The operator makes one with `whipple keys create`; it "
        "has the scopes `read`, `submit` or `admin`, and goes with each request.",
    },
    {"name": "operations", "description": "The queue as a whole, and what monitors read."},
]


@router.get("/openapi.json")
def show_openapi(request: Request) -> JSONResponse:
    """The OpenAPI document."""
    return JSONResponse(request.app.openapi())


def _prepare(app: FastAPI) -> None:
    """Name the parts of the documentation, and describe problem documents and report.json."""
    app.openapi_tags = TAGS
    original = app.openapi

    @cache
    def openapi() -> dict[str, JsonValue]:
        document = original()
        document["components"]["schemas"] |= component_schemas()
        return document

    app.openapi = openapi  # type: ignore[method-assign]


ROUTES = Routes("openapi", 70, open=(router,), prepare=_prepare)
