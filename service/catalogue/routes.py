"""The catalogue: scenarios with their parameters, materials with their sources, laws, presets."""

import json
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


def _listed(model: type[BaseModel], items: list[Any]) -> Response:
    """A list as its model describes it."""
    return Response(model.model_validate({"items": items}).model_dump_json(), media_type="application/json")


@open_router.get("/schema/sweep", responses={200: SCHEMA_ANSWER}, response_class=Response)
def show_sweep_schema() -> Response:
    """The JSON Schema of a sweep, for editors and clients; `whipple schema` prints the same."""
    return Response(_schema(), media_type=SCHEMA_JSON)


@cache
def _schema() -> bytes:
    return json.dumps(schema_of_sweep(), ensure_ascii=False).encode()


@router.get("/scenarios", response_model=Items[ScenarioModel])
def list_scenarios() -> Response:
    """Every scenario, with unit, bounds, default and meaning of its parameters."""
    return _listed(Items[ScenarioModel], [scenarios.load(name).describe() for name in scenarios.names()])


@router.get("/materials", response_model=CatalogueModel)
def list_materials() -> Response:
    """Every material that ships, each number with unit, source and confidence."""
    return _listed(CatalogueModel, [materials.load(name).document() for name in materials.names()])


@router.get("/laws", response_model=Items[LawModel])
def list_laws() -> Response:
    """Every law, with equation, source and range."""
    return _listed(Items[LawModel], [laws.load(name).describe() for name in laws.names()])


@router.get("/recipes", response_model=CatalogueModel)
def list_recipes() -> Response:
    """Every preset of numerical parameters: the values of the parameter `recipe`, and what each sets."""
    recipes = [{"name": name, **asdict(recipe), **asdict(IMPACT_RECIPES[name])} for name, recipe in RECIPES.items()]
    return _listed(CatalogueModel, recipes)
