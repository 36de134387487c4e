"""Ten runs keep their identities: parameters that came later stay out of them at the value of before."""

from typing import Any

import pytest

from studies import materials, scenarios
from studies.runs.run import resolve
from tests.contracts.test_scenarios import asked

# Of physics version 8; another version, or another constant of a material in use, changes them with a reason.
IDENTITIES: tuple[tuple[str, dict[str, Any], str], ...] = (
    ("thin_plate", {}, "f2ed10704dd877f5cc2c7ad75d1676e8"),
    ("thin_plate", {"recipe": "thesis"}, "ecf925660377ceac257b373f5575cd47"),
    ("thin_plate", {"geometry": "quarter"}, "00302d93945ca9e04d40ccd10c7e4220"),
    ("thin_plate", {"geometry": "half", "obliquity": 0.5}, "10c64893cf4455ba220aaedae70ac3a1"),
    (
        "thin_plate",
        {"edges": "absorbing", "debris": "follow"},
        "9bb68872a3ae72194f6736eaa6fa8e14",
    ),
    ("thick_plate", {}, "35d0ab589f946a1f51ecfdd71fd57bfd"),
    (
        "thick_plate",
        {"projectile_shape": "cylinder", "projectile_length": 4e-3, "geometry": "half"},
        "00db0d0d2a63da6d0b7ebfae6d80f805",
    ),
    ("taylor_bar", {}, "43bcf4bfa1d329e105dfda2cb1b42982"),
    ("elastic_bar", {}, "a5dc5871dc638e248a2c4754e27439b3"),
    ("plate_impact", {}, "d53918d13f024d42ab1aa08bad46cb09"),
)


@pytest.mark.parametrize(("scenario", "changes", "identity"), IDENTITIES)
def test_identity__is_that_of_before(scenario: str, changes: dict[str, Any], identity: str) -> None:
    assert asked(scenario, **changes).id == identity


@pytest.mark.parametrize(("scenario", "differs"), [("thin_plate", False), ("debris_cloud", True)])
def test_latent_heat__belongs_to_the_identity_of_runs_that_are_measured_with_it(
    scenario: str, differs: bool
) -> None:
    copper = materials.load("copper-ofhc")
    other = copper.with_value("thermal.latent_heat_of_fusion", 1e5)
    run = asked(scenario)
    roles = dict.fromkeys(scenarios.load(scenario).materials, other)
    assert (resolve(scenario, run.parameters, roles).id != run.id) == differs
