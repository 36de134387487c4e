"""What may be asked for: scenarios with their parameters, materials with their sources, laws, presets."""

from dataclasses import asdict

from fastapi import APIRouter

from service.api.schemas import CatalogueModel, ParameterModel, ScenarioCatalogue, ScenarioModel
from studies import laws, materials, scenarios
from studies.values.parameters import declared, describe
from studies.values.recipes import ACCURACY, IMPACT_RECIPES, RECIPES

router = APIRouter(prefix="/v1", tags=["catalogue"])


@router.get("/scenarios")
def list_scenarios() -> ScenarioCatalogue:
    """Every scenario, with unit, bounds, default and meaning of its parameters."""
    return ScenarioCatalogue(items=[_scenario(name) for name in scenarios.names()])


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
    """Every preset of resolutions and sub-cell offsets: what `accuracy` of a sweep may say."""
    return CatalogueModel(items=[{"name": name, **asdict(one)} for name, one in ACCURACY.items()])


@router.get("/recipes")
def list_recipes() -> CatalogueModel:
    """Every preset of numerical parameters: what the parameter `recipe` may say, and what it fills in."""
    return CatalogueModel(
        items=[
            {"name": name, **asdict(one), **asdict(IMPACT_RECIPES[name])}
            for name, one in RECIPES.items()
        ]
    )


def _scenario(name: str) -> ScenarioModel:
    scenario = scenarios.load(name)
    parameters = describe(declared(scenario.parameters).values())
    return ScenarioModel(
        name=scenario.name,
        title=scenario.title,
        description=scenario.description,
        materials=scenario.materials,
        measurements=scenario.measurements,
        parameters=[ParameterModel(**one) for one in parameters],
    )
