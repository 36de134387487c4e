"""The schema of report.json, made of the records of sections, in OpenAPI."""

from typing import Any

import jsonschema_rs
import pytest

from service.openapi.routes import component_schemas, report_schemas
from studies.reports.document import schema_of_report
from studies.reports.section import sections
from tests.service.support.api import Api
from tests.studies.support import fakes

HOLES = fakes.cube_of(fakes.refined_holes(), observations=fakes.SHOTS)


def is_described(document: dict[str, Any]) -> bool:
    """Whether the schema holds for a document, as it is read from its file."""
    schema = {
        "$ref": "#/components/schemas/Report",
        "components": {"schemas": report_schemas(schema_of_report(sections()))},
    }
    return jsonschema_rs.is_valid(schema, document)


def test_schema__holds_for_a_report_and_for_one_without_a_section() -> None:
    document = fakes.document_of(HOLES)
    assert {"laws", "convergence", "runs"} <= document.keys()
    assert is_described(document)
    del document["laws"]
    assert is_described(document)


@pytest.mark.parametrize("wrong", [{"laws": {"judgements": [{"law": "hill"}]}}, {"headline": None}])
def test_schema__refuses_other_documents(wrong: dict[str, Any]) -> None:
    assert not is_described({**fakes.document_of(HOLES), **wrong})


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
