"""The catalogue: scenarios with their parameters, materials with their sources, laws, presets; written once."""

from collections.abc import Callable
from dataclasses import asdict

from fastapi import APIRouter, Request, Response
from pydantic import BaseModel, JsonValue

from service.api.dependencies import PostedDocument, in_child
from service.api.once import built_once
from service.api.reading import answered, answered_as_cube
from service.api.routes import Routes
from service.api.schemas import CatalogueModel, Items, ScenarioModel
from studies import laws, materials, scenarios
from studies.answers import examples
from studies.answers.targets import targets
from studies.quantities.numerical_defaults import IMPACT_RECIPES, RECIPES
from studies.quantities.parameters import Plain
from studies.sweeps.accuracy import ACCURACY
from studies.sweeps.document import read_yaml

router = APIRouter(prefix="/v1", tags=["catalogue"])
ROUTES = Routes("catalogue", 60, guarded=(router,))

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
Listing = Callable[[], BaseModel]


def written_once(path: str, model: type[BaseModel]) -> Callable[[Listing], Listing]:
    """Add an endpoint for a list that never changes: its response is written by the first request."""

    def add(catalogue: Listing) -> Listing:
        @built_once
        def written() -> bytes:
            return catalogue().model_dump_json(by_alias=True).encode()

        def endpoint() -> Response:
            return Response(written(), media_type="application/json")

        router.get(path, name=catalogue.__name__, description=catalogue.__doc__, response_model=model)(endpoint)
        return catalogue

    return add


@written_once("/scenarios", Items[ScenarioModel])
def list_scenarios() -> Items[ScenarioModel]:
    """Every scenario, with unit, bounds, default and meaning of its parameters."""
    return Items(items=[ScenarioModel.model_validate(scenarios.load(name).describe()) for name in scenarios.names()])


@written_once("/materials", CatalogueModel)
def list_materials() -> CatalogueModel:
    """Every material that ships, each number with unit, source and confidence."""
    return CatalogueModel.model_validate({"items": [materials.load(name).document() for name in materials.names()]})


@written_once("/laws", CatalogueModel)
def list_laws() -> CatalogueModel:
    """Every law, with equation, source and range."""
    return CatalogueModel.model_validate({"items": [laws.load(name).describe() for name in laws.names()]})


@router.post("/laws/evaluate", openapi_extra=_question_body(), responses={200: QUESTION_ANSWER})
async def evaluate_laws(request: Request, posted: PostedDocument) -> Response:
    """What every law says of a shot, or of many: value, whether it is in range, source, and the nearest shots.

    Nothing is stored or run. With `Accept: application/x-netcdf` the answer is a cube.
    """
    as_cube = NETCDF in request.headers.get("accept", "")
    content = await in_child(request, answered_as_cube if as_cube else answered, posted)
    return Response(content, media_type=NETCDF if as_cube else "application/json")


@written_once("/accuracies", CatalogueModel)
def list_accuracies() -> CatalogueModel:
    """The names that `accuracy` in a sweep may have, each with its mesh error, relative."""
    return CatalogueModel(items=[{"name": name, "error": error} for name, error in ACCURACY.items()])


@written_once("/recipes", CatalogueModel)
def list_recipes() -> CatalogueModel:
    """Every preset of numerical parameters: the values of the parameter `recipe`, and what each sets."""
    return CatalogueModel(
        items=[{"name": name, **asdict(recipe), **asdict(IMPACT_RECIPES[name])} for name, recipe in RECIPES.items()]
    )
