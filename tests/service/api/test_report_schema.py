"""The schema of report.json, made of the records of sections, in OpenAPI."""

import json
from dataclasses import asdict, dataclass
from enum import StrEnum
from typing import Any

import jsonschema_rs
import pytest

from service.api.schemas import component_schemas, report_schemas
from studies.reports.schema import schema_of_report
from tests.service.support.api import Api


class Outcome(StrEnum):
    WITHIN = "within"
    LOW = "low"


@dataclass(frozen=True)
class Point:
    """A law at a point."""

    at: tuple[float, ...]
    bar: float | None
    outcome: Outcome


@dataclass(frozen=True)
class Law:
    """A law at all points."""

    name: str
    points: tuple[Point, ...]


LAWS = (Law("Hill", (Point((3e3, 0.002), None, Outcome.LOW),)),)
REPORT = {"report_version": 16, "title": "Holes", "headline": "Hole 14.3 mm.", "worst": asdict(LAWS[0].points[0])}


def is_described(document: dict[str, Any]) -> bool:
    """Whether the schema of the two sections holds for a document, as it is read from its file."""
    components = report_schemas(schema_of_report({"laws": tuple[Law, ...], "worst": Point}))
    schema = {"$ref": "#/components/schemas/Report", "components": {"schemas": components}}
    return jsonschema_rs.is_valid(schema, json.loads(json.dumps(document)))


@pytest.mark.parametrize("more", [{"laws": [asdict(law) for law in LAWS]}, {"laws": []}, {"laws": None}, {}])
def test_schema__holds_for_the_records_of_its_sections_or_none(more: dict[str, Any]) -> None:
    assert is_described({**REPORT, **more})


@pytest.mark.parametrize("wrong", [{"laws": [{"name": "Hill"}]}, {"headline": None}, {"worst": {"outcome": "good"}}])
def test_schema__refuses_other_documents(wrong: dict[str, Any]) -> None:
    assert not is_described({**REPORT, **wrong})


def test_components__of_records_are_apart_from_those_of_the_service() -> None:
    components = report_schemas(schema_of_report({"laws": tuple[Law, ...]}))
    assert set(components) == {"Report", "Report.Law", "Report.Point", "Report.Outcome"}
    assert components["Report"]["title"] == "Report"
    assert components["Report.Law"]["description"] == Law.__doc__


def test_openapi__refers_to_components_that_are_there(shared_api: Api) -> None:
    document = shared_api.http.get("/openapi.json").json()
    answer = document["paths"]["/v1/sweeps/{id}/report.json"]["get"]["responses"]["200"]
    assert answer["content"]["application/json"]["schema"] == {"$ref": "#/components/schemas/Report"}
    components = document["components"]["schemas"]
    assert components.items() >= component_schemas().items()
    assert {reference.rpartition("/")[2] for reference in _references(document)} <= components.keys()


def _references(value: Any) -> set[str]:
    """Every reference in a document."""
    if isinstance(value, dict):
        here = {value["$ref"]} if isinstance(value.get("$ref"), str) else set()
        return here.union(*map(_references, value.values()))
    return set().union(*map(_references, value)) if isinstance(value, list) else set()
