"""Constants of a material belong to the identity of the runs that use them."""

import pytest

from studies import materials, scenarios
from studies.runs.run import resolve
from tests.contracts.test_scenarios import asked


@pytest.mark.parametrize(("scenario", "differs"), [("thin_plate", False), ("debris_cloud", True)])
def test_latent_heat__belongs_to_the_identity_of_runs_that_are_measured_with_it(scenario: str, differs: bool) -> None:
    copper = materials.load("copper-ofhc")
    other = copper.with_value("thermal.latent_heat_of_fusion", 1e5)
    run = asked(scenario)
    roles = dict.fromkeys(scenarios.load(scenario).materials, other)
    assert (resolve(scenario, run.parameters, roles).id != run.id) == differs


# A constant, a material that has it, and two runs: only the second uses it.
OF_MODELS = [
    ("tension.spall_strength", "copper-ofhc", {"tension": "unlimited"}, {}),
    ("fracture.D1", "weldox-460-e", {}, {"failure": "modified-johnson-cook"}),
]


@pytest.mark.parametrize(("path", "name", "without", "using"), OF_MODELS)
def test_constant__of_a_model_belongs_to_the_identity_of_runs_that_choose_the_model(
    path: str, name: str, without: dict[str, str], using: dict[str, str]
) -> None:
    material = materials.load(name)
    value = material.value_at(path)
    assert value is not None
    other = material.with_value(path, 0.9 * value)
    differ = []
    for changes in (without, using):
        run = asked("thin_plate", projectile=name, target=name, **changes)
        roles = {"projectile": other, "target": other}
        differ.append(resolve("thin_plate", run.parameters, roles).id != run.id)
    assert differ == [False, True]
