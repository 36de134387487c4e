"""The catalogue: scenarios with their parameters, materials with their sources, laws, presets."""

from dataclasses import asdict

from fastapi import APIRouter

from service.api.schemas import CatalogueModel, Items, ScenarioModel
from studies import laws, materials, scenarios
from studies.values.recipes import ACCURACY, IMPACT_RECIPES, RECIPES

router = APIRouter(prefix="/v1", tags=["catalogue"])


@router.get("/scenarios")
def list_scenarios() -> Items[ScenarioModel]:
    """Every scenario, with unit, bounds, default and meaning of its parameters."""
    return Items(
        items=[ScenarioModel(**scenarios.load(name).describe()) for name in scenarios.names()]
    )


@router.get("/materials")
def list_materials() -> CatalogueModel:
    """Every material that ships, each number with unit, source and confidence."""
    return CatalogueModel(items=[materials.load(name).document() for name in materials.names()])


@router.get("/laws")
def list_laws() -> CatalogueModel:
    """Every law, with equation, source and range."""
    return CatalogueModel(items=[laws.load(name).describe() for name in laws.names()])


@router.get("/accuracies")
def list_accuracies() -> CatalogueModel:
    """Every preset of resolutions and sub-cell offsets: the values of `accuracy` in a sweep."""
    return CatalogueModel(
        items=[{"name": name, **asdict(preset)} for name, preset in ACCURACY.items()]
    )


@router.get("/recipes")
def list_recipes() -> CatalogueModel:
    """Every preset of numerical parameters: the values of the parameter `recipe`, and what each sets."""
    return CatalogueModel(
        items=[
            {"name": name, **asdict(recipe), **asdict(IMPACT_RECIPES[name])}
            for name, recipe in RECIPES.items()
        ]
    )
