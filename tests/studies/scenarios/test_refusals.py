"""What scenarios refuse of parameters together: the field, and words of its limit or cure."""

from typing import Any

import pytest

from studies.quantities.findings import InvalidInput
from tests import samples
from tests.contracts.test_scenarios import asked

STRAIN = {"failure": "plastic-strain", "failure_strain": 1.0}
SPALL = {"failure": "spall", "failure_time": 1e-6}
PULSE = "0 us 0, 0.5 us 1, 10 us 1, 10.5 us 0"


def bar(name: str, reason: str, **changes: Any) -> tuple[str, dict[str, Any], str, str]:
    return "elastic_bar", changes, name, reason


def pulse(reason: str, text: str) -> tuple[str, dict[str, Any], str, str]:
    return bar("pulse", reason, pressure=1e8, pulse=text)


REFUSED: list[tuple[str, dict[str, Any], str, str]] = [
    *(
        (name, {"contact": "repulsion"}, "parameters.contact", "repulsion")
        for name in ("thin_plate", "thick_plate", "plate_impact")
    ),
    # Loads on bars.
    bar("pulse", "give pressure", pulse=PULSE),
    pulse("at least two rows", "1 us 1"),
    pulse("a time with its unit", "0 us, 1 us 1"),
    pulse("from -1 to 1", "0 us 0, 1 us 2"),
    pulse("from 0 s", "-1 us 0, 1 us 1"),
    pulse("after 1 us", "0 us 0, 1 us 1, 1 us 0"),
    pulse("before the end of the run", "1 s 0, 2 s 1"),
    bar("pressure", "at most", pressure=1e12),
    bar("gravity", "at most", gravity=1e12),
    bar("speed", "without loads", speed=0.0),
    bar("bar_length", "8 cells", pressure=1e8, bar_length=7e-3),
    bar("bar_length", "at least a cell", bar_length=0.5e-3),
    bar("section", "set geometry to quarter", section="square"),
    bar("contact", "set contact to none", method="sph", geometry="quarter", wall="symmetric", contact="gap"),
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
    ("taylor_bar", {"bar": "copper-ofhc-tillotson", "thermal_softening": False}, "thermal_softening", "would boil"),
    # Sizes, angles and numerics.
    ("thin_plate", {"projectile_shape": "cylinder"}, "projectile_length", "the length of the cylinder"),
    ("thin_plate", {"projectile_length": 4e-3}, "projectile_length", "a sphere without a length"),
    ("thin_plate", {"plate_radius": 7e-3}, "plate_radius", "at least the projectile's diameter"),
    ("thin_plate", {"plate_thickness": 0.9e-3}, "plate_thickness", "at least half a cell"),
    ("thin_plate", {"obliquity": 0.3}, "obliquity", "set geometry to half"),
    ("thin_plate", {"geometry": "half", "yaw": 0.1}, "yaw", "use a cylinder"),
    ("thin_plate", {"friction": 0.1}, "friction", "set contact to bardenhagen"),
    ("taylor_bar", {"friction": 0.1}, "friction", "set contact to bardenhagen"),
    ("thin_plate", {"film_interval": 1e-12}, "film_interval", "a thousandth of the run"),
    ("thick_plate", {"target_depth": 7e-3}, "target_depth", "at least 1 of the projectile's diameter"),
    ("thick_plate", {"edges": "absorbing", "target_depth": 0.04}, "target_radius", "choose other edges"),
    bar("speed", "holds only far below this limit", young_modulus=1e7),
    ("plate_impact", {"target_thickness": 1e-3}, "target_thickness", "at least ten cells"),
    ("plate_impact", {"flyer": "copper-ofhc-tillotson"}, "flyer", "use mie-grueneisen"),
    ("plate_impact", {"target": "armco-iron", "failure": "spall-rate"}, "failure", "choose another failure"),
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
