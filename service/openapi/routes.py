"""The OpenAPI document, open to callers without a key, as it names no sweep; components that no route has."""

from functools import cache

from fastapi import APIRouter, FastAPI, Request
from fastapi.responses import JSONResponse
from pydantic import Field, JsonValue, TypeAdapter
from pydantic.json_schema import models_json_schema

from service.api.routes import Routes, all_routes
from service.api.schemas import COMPONENTS, REPORT, Answer
from studies.reports.document import Head, schema_of_report
from studies.reports.section import sections
from studies.sweeps.schema import definitions

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


class ErrorItem(Answer):
    """An error in an input."""

    field: str = Field(description="Dotted path in the document", examples=["axes.speed[2]"])
    value: str = Field(description="The refused value, shortened")
    limit: str = Field(description="The allowed values")
    cure: str = Field(description="How to correct it")
    pointer: str = Field(description="JSON pointer (RFC 6901) to the place in the document")


class ProblemDocument(Answer):
    """An error (RFC 9457)."""

    type: str = Field(description="Kind of problem, a stable URI", examples=["/docs#problem-not-found"])
    title: str
    status: int
    detail: str
    instance: str = Field(description="Path of the request")
    request_id: str | None = Field(description="Id of the request in the log of the service")
    errors: list[ErrorItem] | None = Field(None, description="First errors of a refused input")
    more_errors: int | None = Field(
        None, description="Number of errors left out of `errors`; checking stops after 200 errors"
    )


def component_schemas() -> dict[str, JsonValue]:
    """The schemas of problem documents, of report.json, of a sweep and of what features add, for OpenAPI."""
    template = COMPONENTS + "{model}"
    problems = models_json_schema([(ProblemDocument, "serialization")], ref_template=template)[1]["$defs"]
    schemas = {**problems, **report_schemas(schema_of_report(sections())), **definitions(COMPONENTS)}
    for routes in all_routes():
        schemas |= routes.components() if routes.components else {}
    return schemas


def report_schemas(adapter: TypeAdapter[Head]) -> dict[str, JsonValue]:
    """The components of report.json; those of its records begin with "Report.", as others may have their names."""
    report = adapter.json_schema(mode="serialization", ref_template=f"{COMPONENTS}{REPORT}.{{model}}")
    records = {f"{REPORT}.{name}": schema for name, schema in report.pop("$defs", {}).items()}
    # Generated clients name a class by the title.
    return {REPORT: report, **{name: {**schema, "title": name} for name, schema in records.items()}}
