"""What scenarios refuse of parameters together: the field, and words of its limit or cure."""

from typing import Any

import pytest

from studies.quantities.findings import InvalidInput
from tests import samples
from tests.contracts.test_scenarios import asked

STRAIN = {"failure": "plastic-strain", "failure_strain": 1.0}
SPALL = {"failure": "spall", "failure_time": 1e-6}
REFUSED: list[tuple[str, dict[str, Any], str, str]] = [
    *((name, {"contact": "repulsion"}, "parameters.contact", "repulsion") for name in ("thin_plate", "thick_plate")),
    # Matter that does not go with a model.
    ("thin_plate", {"failure": "plastic-strain"}, "failure_strain", "a value for failure plastic-strain"),
    ("thin_plate", {"failure": "spall"}, "failure_time", "give failure_time"),
    ("thin_plate", {"failure_strain": 1.0}, "failure_strain", "no value without failure plastic-strain"),
    ("thin_plate", {"failure": "none", "rubble_friction": 0.6}, "rubble_friction", "no rubble without a failure"),
    ("thin_plate", {**STRAIN, "failure_time": 1e-6}, "failure_time", "set failure to spall"),
    ("thin_plate", {**SPALL, "target": "copper-thesis-plastic"}, "failure", "set target.tension.spall_strength"),
    *(
        ("thin_plate", {"failure": "johnson-cook", "target": target}, "failure", f"fracture strain D1, which {target}")
        for target in ("al-1100-o", "al-2017-t4", "al-2219-t87", "steel-304")
    ),
    *(
        ("thin_plate", {"failure": "spall-rate", "target": target}, "failure", f"of its source, which {target} has not")
        for target in ("al-1100-o", "al-5456-h116", "armco-iron", "lead", "tungsten")
    ),
    ("thin_plate", {"target": "copper-ofhc-tillotson", "eos_form": "cubic"}, "eos_form", "has one form"),
    *(
        (scenario, {**materials, "failure": "none", **change}, next(iter(change)), "would boil")
        for scenario in ("thin_plate", "thick_plate")
        for materials in [dict.fromkeys(("projectile", "target"), "copper-ofhc-tillotson")]
        for change in ({"tension": "unlimited"}, {"thermal_softening": False})
    ),
    # Sizes, angles and numerics.
    ("thin_plate", {"projectile_shape": "cylinder"}, "projectile_length", "the length of the cylinder"),
    ("thin_plate", {"projectile_length": 4e-3}, "projectile_length", "a sphere without a length"),
    ("thin_plate", {"plate_radius": 7e-3}, "plate_radius", "at least the projectile's diameter"),
    ("thin_plate", {"plate_thickness": 0.9e-3}, "plate_thickness", "at least half a cell"),
    ("thin_plate", {"obliquity": 0.3}, "obliquity", "set geometry to half"),
    ("thin_plate", {"geometry": "half", "yaw": 0.1}, "yaw", "use a cylinder"),
    ("thin_plate", {"friction": 0.1}, "friction", "set contact to bardenhagen"),
    ("thin_plate", {"film_interval": 1e-12}, "film_interval", "a thousandth of the run"),
    ("thick_plate", {"target_depth": 7e-3}, "target_depth", "at least 1 of the projectile's diameter"),
    ("thick_plate", {"edges": "absorbing", "target_depth": 0.04}, "target_radius", "choose other edges"),
    *(row for rows in samples.offered("REFUSED") for row in rows if samples.is_there(*row[:2])),
]


@pytest.mark.parametrize(
    ("scenario", "changes", "field", "reason"), REFUSED, ids=[f"{row[0]} {row[2]} {row[3][:20]}" for row in REFUSED]
)
def test_scenario__refuses_with_field_and_reason(
    scenario: str, changes: dict[str, Any], field: str, reason: str
) -> None:
    with pytest.raises(InvalidInput, match=reason) as caught:
        asked(scenario, **changes)
    assert field in [finding.field for finding in caught.value.findings]
