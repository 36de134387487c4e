"""What laws and shots say of a shot, over HTTP."""

from fastapi import APIRouter, Request, Response
from pydantic import JsonValue

from service.answers.reading import answered, answered_as_cube
from service.api.dependencies import PostedDocument, in_child
from service.api.routes import Routes
from studies.answers import examples
from studies.answers.targets import targets
from studies.quantities.parameters import Plain
from studies.sweeps.document import read_yaml

router = APIRouter(prefix="/v1", tags=["catalogue"])
ROUTES = Routes("answers", 61, guarded=(router,))

NETCDF = "application/x-netcdf"


def _question_body() -> dict[str, Plain]:
    """What may be posted as a question: the parameters of each target, and an example that ships."""
    stated = " or ".join(
        f"at a {target.name} ({', '.join(f'`{n}`' for n in target.stated)})" for target in targets().values()
    )
    several = "A parameter may have several values: a list, or `start`, `stop` and `step`."
    as_json: dict[str, Plain] = {"schema": {"type": "object"}}
    if shipped := examples():
        as_json["example"] = read_yaml(shipped[0].read_text(encoding="utf-8"), shipped[0].name)
    return {
        "requestBody": {
            "required": True,
            "description": f"A shot {stated}, or the document of a sweep. {several}",
            "content": {"application/json": as_json, "application/yaml": {"schema": {"type": "object"}}},
        }
    }


QUESTION_ANSWER: dict[str, JsonValue] = {
    "description": "The answer to each shot, and what the catalogue says of each law",
    "content": {
        "application/json": {"schema": {"type": "object"}},
        NETCDF: {"schema": {"type": "string", "format": "binary"}},
    },
}


@router.post("/laws/evaluate", openapi_extra=_question_body(), responses={200: QUESTION_ANSWER})
async def evaluate_laws(request: Request, posted: PostedDocument) -> Response:
    """What every law says of a shot, or of many: value, whether it is in range, source, and the nearest shots.

    Nothing is stored or run. With `Accept: application/x-netcdf` the answer is a cube.
    """
    as_cube = NETCDF in request.headers.get("accept", "")
    content = await in_child(request, answered_as_cube if as_cube else answered, posted)
    return Response(content, media_type=NETCDF if as_cube else "application/json")
