"""A material becomes matter; models and constants that do not go together are refused."""

import dataclasses
import math
from typing import Any

import pytest

from solver.matter.failure.johnson_cook import ModifiedJohnsonCookDamage
from solver.matter.failure.none import NoFailure
from solver.matter.failure.plastic_strain import PlasticStrainLimit
from solver.matter.failure.spall import Spall
from solver.matter.strength.steinberg_guinan import SteinbergGuinan
from solver.matter.tension.recoverable import RecoverableTension
from solver.matter.tension.unlimited import UnlimitedTension
from solver.steppers import methods
from studies import materials
from studies.quantities.parameters import Value, nested
from studies.scenarios import Materials
from studies.scenarios.parts.matter import Fracture, check_constants, matter
from tests.contracts.test_scenarios import asked
from tests.samples import needs

COPPER = materials.load("copper-ofhc")
THESIS = materials.load("copper-thesis-plastic")  # no spall strength
STEINBERG = (120e6, 640e6, 36.0, 0.45, 28.3e-12, 3.77e-4)  # of copper
PRESSED = dataclasses.replace(
    COPPER, strength=materials.Model("steinberg-guinan", dict(zip(SteinbergGuinan._fields, STEINBERG, strict=True)))
)
ROLES: Materials = {"projectile": COPPER, "target": COPPER}


def test_matter__has_the_constants_of_the_material() -> None:
    made = matter(COPPER)
    assert (made.eos._asdict()["c0"], made.eos.temperature) == (3940.0, 294.0)
    assert made.tension == RecoverableTension(1.9e9)
    assert (made.room_temperature, made.melt_temperature) == (294.0, 1356.0)
    assert made.failure == NoFailure()
    assert matter(PRESSED).strength == SteinbergGuinan(*STEINBERG)
    assert matter(COPPER, thermal_softening=False).melt_temperature == math.inf


@pytest.mark.parametrize(
    ("material", "path", "value", "limit"),
    [
        (PRESSED, "strength.Y0", 641e6, "at most target.strength.Y_max, 640 MPa"),
        ("copper-ofhc-tillotson", "eos.e_iv", 6.9e6, "below target.eos.e_cv, 6900000 J kg-1"),
        ("copper-ofhc", "thermal.room_temperature", 1356.0, "below target.thermal.melt_temp"),
    ],
)
def test_constants__that_have_an_order_are_refused_out_of_it(
    material: Any, path: str, value: float, limit: str
) -> None:
    right = materials.load(material) if isinstance(material, str) else material
    assert check_constants({"target": right}) == []
    wrong = right.with_value(path, value)
    [finding] = check_constants({"projectile": COPPER, "target": wrong})
    assert finding.field == f"target.{path}"
    assert finding.limit.startswith(limit)


@pytest.mark.parametrize(("material", "tension"), [(COPPER, "unlimited"), (THESIS, "recoverable")])
def test_matter__without_a_spall_strength_or_a_floor_bears_any_tension(material: Any, tension: str) -> None:
    assert isinstance(matter(material, tension=tension).tension, UnlimitedTension)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({"failure": "none"}, NoFailure()),
        ({"failure": "plastic-strain", "failure_strain": 2.0}, PlasticStrainLimit(2.0)),
        ({"failure": "spall", "failure_time": 1e-6}, Spall(1.9e9, 1e-6)),
    ],
)
def test_failure__is_that_of_the_parameters_with_the_constants_of_the_material(
    given: dict[str, Value], expected: object
) -> None:
    fracture = nested(Fracture, given)
    assert list(fracture.check(ROLES)) == []
    assert fracture.of(COPPER) == expected


def test_damage__breaks_the_materials_that_state_its_constants() -> None:
    arne, weldox = materials.load("arne-elastic"), materials.load("weldox-460-e")
    damage = Fracture(failure="modified-johnson-cook")
    assert list(damage.check({"projectile": arne, "target": weldox})) == []
    assert damage.of(arne) == NoFailure()
    assert damage.of(weldox) == ModifiedJohnsonCookDamage(0.0705, 1.732, -0.54, -0.0123, 0.0, 5e-4, 0.3, 0.0)


@pytest.mark.parametrize(
    ("scenario", "changes", "expected"),
    [
        ("thin_plate", {}, "void-growth"),
        ("thick_plate", {}, "void-growth"),
        ("thin_plate", {"projectile": "lead"}, "void-growth"),  # a projectile without constants never fails
        ("thin_plate", {"target": "al-2017-t4"}, "none"),
        ("thin_plate", {"failure": "none"}, "none"),
        *([("thin_plate", {"method": "sph", "geometry": "quarter"}, "none")] if "sph" in methods() else []),
        pytest.param("plate_impact", {}, "none", marks=needs("plate_impact")),
    ],
)
def test_failure__is_void_growth_by_default_where_the_target_has_its_constants(
    scenario: str, changes: dict[str, Any], expected: str
) -> None:
    assert asked(scenario, **changes).parameters["failure"] == expected
