"""The catalogue: scenarios with their parameters, materials with their sources, laws, presets; written once."""

import json
from collections.abc import Callable
from dataclasses import asdict
from functools import cache
from typing import Any

from fastapi import APIRouter, Response
from pydantic import BaseModel

from service.api.routes import Routes
from service.api.schemas import CatalogueModel, Items, LawModel, ScenarioModel
from studies import laws, materials, scenarios
from studies.quantities.numerical_defaults import IMPACT_RECIPES, RECIPES
from studies.sweeps.schema import schema_of_sweep

router = APIRouter(prefix="/v1", tags=["catalogue"])
open_router = APIRouter(prefix="/v1", tags=["catalogue"])  # editors have no key
ROUTES = Routes("catalogue", 60, guarded=(router,), open=(open_router,))
SCHEMA_JSON = "application/schema+json"
SCHEMA_ANSWER: dict[str, Any] = {"content": {SCHEMA_JSON: {"schema": {"type": "object"}}}}

Listing = Callable[[], BaseModel]


def written_once(path: str, model: type[BaseModel]) -> Callable[[Listing], Listing]:
    """Add an endpoint for a list that never changes: its response is written by the first request."""

    def add(catalogue: Listing) -> Listing:
        @cache
        def written() -> bytes:
            return catalogue().model_dump_json(by_alias=True).encode()

        def endpoint() -> Response:
            return Response(written(), media_type="application/json")

        router.get(path, name=catalogue.__name__, description=catalogue.__doc__, response_model=model)(endpoint)
        return catalogue

    return add


@open_router.get("/schema/sweep", responses={200: SCHEMA_ANSWER}, response_class=Response)
def show_sweep_schema() -> Response:
    """The JSON Schema of a sweep, for editors and clients; `whipple schema` prints the same."""
    return Response(_schema(), media_type=SCHEMA_JSON)


@cache
def _schema() -> bytes:
    return json.dumps(schema_of_sweep(), ensure_ascii=False).encode()


@written_once("/scenarios", Items[ScenarioModel])
def list_scenarios() -> Items[ScenarioModel]:
    """Every scenario, with unit, bounds, default and meaning of its parameters."""
    return Items(items=[ScenarioModel.model_validate(scenarios.load(name).describe()) for name in scenarios.names()])


@written_once("/materials", CatalogueModel)
def list_materials() -> CatalogueModel:
    """Every material that ships, each number with unit, source and confidence."""
    return CatalogueModel.model_validate({"items": [materials.load(name).document() for name in materials.names()]})


@written_once("/laws", Items[LawModel])
def list_laws() -> Items[LawModel]:
    """Every law, with equation, source and range."""
    return Items(items=[LawModel.model_validate(laws.load(name).describe()) for name in laws.names()])


@written_once("/recipes", CatalogueModel)
def list_recipes() -> CatalogueModel:
    """Every preset of numerical parameters: the values of the parameter `recipe`, and what each sets."""
    return CatalogueModel(
        items=[{"name": name, **asdict(recipe), **asdict(IMPACT_RECIPES[name])} for name, recipe in RECIPES.items()]
    )
