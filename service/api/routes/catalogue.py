"""The catalogue: scenarios with their parameters, materials with their sources, laws, presets; written once."""

import threading
from collections.abc import Callable
from dataclasses import asdict
from functools import cache

from fastapi import APIRouter, Request, Response
from pydantic import BaseModel, JsonValue

from service.api.dependencies import PostedDocument, in_child
from service.api.reading import answered, answered_as_cube
from service.api.routes import Routes
from service.api.schemas import CatalogueModel, Items, ScenarioModel
from studies import laws, materials, scenarios
from studies.quantities.numerical_defaults import IMPACT_RECIPES, RECIPES
from studies.sweeps.accuracy import ACCURACY

router = APIRouter(prefix="/v1", tags=["catalogue"])
ROUTES = Routes("catalogue", 60, guarded=(router,))

NETCDF = "application/x-netcdf"
QUESTION: dict[str, JsonValue] = {
    "speed": ["3 km/s", "6 km/s"],
    "projectile": "al-2017-t4",
    "projectile_diameter": "5 mm",
    "bumper": "al-6061-t6",
    "bumper_thickness": "1.2 mm",
    "stand_off": "10 cm",
    "wall": "al-6061-t6",
    "wall_thickness": "3.2 mm",
}
QUESTION_BODY: dict[str, JsonValue] = {
    "requestBody": {
        "required": True,
        "description": (
            "A shot at a block (`target`), at a plate (`plate_thickness` too) or at a shield (`bumper`, "
            "`bumper_thickness`, `stand_off`, `wall`, `wall_thickness`, and a list `further_bumpers`), or the document "
            "of a sweep. A parameter may have several values: a list, or `start`, `stop` and `step`."
        ),
        "content": {
            "application/json": {"schema": {"type": "object"}, "example": QUESTION},
            "application/yaml": {"schema": {"type": "object"}},
        },
    }
}
QUESTION_ANSWER: dict[str, JsonValue] = {
    "description": "The answer to each shot, and what the catalogue says of each law",
    "content": {
        "application/json": {"schema": {"type": "object"}},
        NETCDF: {"schema": {"type": "string", "format": "binary"}},
    },
}
WRITING = threading.Lock()  # ``cache`` alone lets every thread that finds nothing write the catalogue
Listing = Callable[[], BaseModel]


def written_once(path: str, model: type[BaseModel]) -> Callable[[Listing], Listing]:
    """Add an endpoint for a list that never changes: its response is written by the first request."""

    def add(catalogue: Listing) -> Listing:
        @cache
        def written() -> bytes:
            return catalogue().model_dump_json(by_alias=True).encode()

        def endpoint() -> Response:
            with WRITING:
                return Response(written(), media_type="application/json")

        router.get(path, name=catalogue.__name__, description=catalogue.__doc__, response_model=model)(endpoint)
        return catalogue

    return add


@written_once("/scenarios", Items[ScenarioModel])
def list_scenarios() -> Items[ScenarioModel]:
    """Every scenario, with unit, bounds, default and meaning of its parameters."""
    return Items(items=[ScenarioModel(**scenarios.load(name).describe()) for name in scenarios.names()])


@written_once("/materials", CatalogueModel)
def list_materials() -> CatalogueModel:
    """Every material that ships, each number with unit, source and confidence."""
    return CatalogueModel.model_validate({"items": [materials.load(name).document() for name in materials.names()]})


@written_once("/laws", CatalogueModel)
def list_laws() -> CatalogueModel:
    """Every law, with equation, source and range."""
    return CatalogueModel.model_validate({"items": [laws.load(name).describe() for name in laws.names()]})


@router.post("/laws/evaluate", openapi_extra=QUESTION_BODY, responses={200: QUESTION_ANSWER})
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
