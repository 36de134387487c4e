"""What laws and shots say of a shot, over HTTP."""

from fastapi import APIRouter, Request, Response
from pydantic import JsonValue

from service.answers.reading import answered, answered_as_cube
from service.api.dependencies import PostedDocument, in_child
from service.api.routes import Routes
from service.api.schemas import COMPONENTS
from studies.answers import examples
from studies.answers.question import records
from studies.quantities.parameters import Plain
from studies.sweeps.document import read_yaml
from studies.sweeps.schema import Schemas, definitions_of_shot

router = APIRouter(prefix="/v1", tags=["catalogue"])
QUESTION, ANSWER = "Question", "LawsAnswer"  # components of OpenAPI


def _components() -> Schemas:
    """The schemas of a question and of its answer."""
    from service.answers.schemas import answer_schemas

    return {**answer_schemas(ANSWER), **definitions_of_shot(QUESTION, records(), COMPONENTS)}


ROUTES = Routes("answers", 61, guarded=(router,), components=_components)

NETCDF = "application/x-netcdf"


QUESTION_SCHEMA: dict[str, Plain] = {"schema": {"$ref": COMPONENTS + QUESTION}}
QUESTION_BODY: dict[str, Plain] = {
    "requestBody": {
        "required": True,
        "description": "A shot, or the document of a sweep. Parameters may have several values.",
        "content": {
            "application/json": {
                **QUESTION_SCHEMA,
                "examples": {
                    file.stem: {"value": read_yaml(file.read_text(encoding="utf-8"), file.name)} for file in examples()
                },
            },
            "application/yaml": QUESTION_SCHEMA,
        },
    }
}
QUESTION_ANSWER: dict[str, JsonValue] = {
    "description": "The answer to each shot, and what the catalogue says of each law",
    "content": {
        "application/json": {"schema": {"$ref": COMPONENTS + ANSWER}},
        NETCDF: {"schema": {"type": "string", "format": "binary"}},
    },
}


@router.post("/laws/evaluate", openapi_extra=QUESTION_BODY, responses={200: QUESTION_ANSWER})
async def evaluate_laws(request: Request, posted: PostedDocument) -> Response:
    """What every law says of a shot, or of many: value, whether it is in range, source, and the nearest shots.

    Nothing is stored or run. With `Accept: application/x-netcdf` the answer is a cube.
    """
    as_cube = NETCDF in request.headers.get("accept", "")
    content = await in_child(request, answered_as_cube if as_cube else answered, posted)
    return Response(content, media_type=NETCDF if as_cube else "application/json")
