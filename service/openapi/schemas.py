"""Components of the OpenAPI document: problems, and the report for programs."""

from pydantic import Field, JsonValue, TypeAdapter
from pydantic.json_schema import models_json_schema

from service.api.routes import all_routes
from service.api.schemas import COMPONENTS, REPORT, Answer
from studies.reports.document import Head, schema_of_report
from studies.reports.section import sections
from studies.sweeps.schema import definitions


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
