"""The catalogue: scenarios with their parameters, materials with their sources, laws, presets; written once."""

import threading
from collections.abc import Callable
from dataclasses import asdict
from functools import cache

from fastapi import APIRouter, Response
from pydantic import BaseModel

from service.api.schemas import CatalogueModel, Items, ScenarioModel
from studies import laws, materials, scenarios
from studies.values.recipes import ACCURACY, IMPACT_RECIPES, RECIPES

router = APIRouter(prefix="/v1", tags=["catalogue"])

WRITING = threading.Lock()  # ``cache`` alone lets every thread that finds nothing write the catalogue


@cache
def _written(catalogue: Callable[[], BaseModel]) -> bytes:
    return catalogue().model_dump_json(by_alias=True).encode()


def _response(catalogue: Callable[[], BaseModel]) -> Response:
    with WRITING:
        written = _written(catalogue)
    return Response(written, media_type="application/json")


def _scenarios() -> Items[ScenarioModel]:
    names = scenarios.names()
    return Items(items=[ScenarioModel(**scenarios.load(name).describe()) for name in names])


def _materials() -> CatalogueModel:
    return CatalogueModel(items=[materials.load(name).document() for name in materials.names()])


def _laws() -> CatalogueModel:
    return CatalogueModel(items=[laws.load(name).describe() for name in laws.names()])


def _accuracies() -> CatalogueModel:
    return CatalogueModel(items=[{"name": name, **asdict(preset)} for name, preset in ACCURACY.items()])


def _recipes() -> CatalogueModel:
    return CatalogueModel(
        items=[{"name": name, **asdict(recipe), **asdict(IMPACT_RECIPES[name])} for name, recipe in RECIPES.items()]
    )


@router.get("/scenarios", response_model=Items[ScenarioModel])
def list_scenarios() -> Response:
    """Every scenario, with unit, bounds, default and meaning of its parameters."""
    return _response(_scenarios)


@router.get("/materials", response_model=CatalogueModel)
def list_materials() -> Response:
    """Every material that ships, each number with unit, source and confidence."""
    return _response(_materials)


@router.get("/laws", response_model=CatalogueModel)
def list_laws() -> Response:
    """Every law, with equation, source and range."""
    return _response(_laws)


@router.get("/accuracies", response_model=CatalogueModel)
def list_accuracies() -> Response:
    """Every preset of resolutions and sub-cell offsets: the values of `accuracy` in a sweep."""
    return _response(_accuracies)


@router.get("/recipes", response_model=CatalogueModel)
def list_recipes() -> Response:
    """Every preset of numerical parameters: the values of the parameter `recipe`, and what each sets."""
    return _response(_recipes)
