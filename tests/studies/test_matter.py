"""A material becomes matter, and a failure is refused where its numbers are missing."""

import math
from typing import Any

import pytest

from solver.failure.none import NoFailure
from solver.failure.plastic_strain import PlasticStrainLimit
from solver.failure.spall import Spall
from solver.tension.recoverable import RecoverableTension
from solver.tension.unlimited import UnlimitedTension
from studies import materials
from studies.scenarios import Materials
from studies.scenarios._matter import Fracture, check_eos, check_failure, failure_of, matter

COPPER = materials.load("copper-ofhc")
THESIS = materials.load("copper-thesis-plastic")  # no spall strength
ROLES: Materials = {"projectile": COPPER, "target": COPPER}


def test_matter__has_the_constants_of_the_material() -> None:
    made = matter(COPPER)
    assert (made.eos.c0, made.eos.temperature) == (3940.0, 294.0)
    assert made.tension == RecoverableTension(1.9e9)
    assert (made.room_temperature, made.melt_temperature) == (294.0, 1356.0)
    assert made.failure == NoFailure()


def test_eos__of_another_kind_has_one_form() -> None:
    boiling = materials.load("copper-ofhc-tillotson")
    roles = {"projectile": COPPER, "target": boiling}
    assert check_eos("hugoniot", roles) == check_eos("cubic", ROLES) == []
    [finding] = check_eos("cubic", roles)
    assert (finding.field, finding.value) == ("eos_form", "cubic")
    assert boiling.name in finding.limit


def test_eos__begins_to_boil_before_it_has_boiled() -> None:
    never = materials.load("copper-ofhc-tillotson").with_value("eos.e_iv", 6.9e6)
    [finding] = check_eos("hugoniot", {"projectile": COPPER, "target": never})
    assert finding.field == "target.eos.e_iv"


def test_matter__without_softening_never_melts() -> None:
    assert matter(COPPER, thermal_softening=False).melt_temperature == math.inf


@pytest.mark.parametrize("material", [COPPER, THESIS])
def test_matter__without_a_spall_strength_or_a_floor_bears_any_tension(material: Any) -> None:
    made = matter(material, tension="unlimited" if material is COPPER else "recoverable")
    assert isinstance(made.tension, UnlimitedTension)


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (Fracture(), NoFailure()),
        (Fracture(failure="plastic-strain", failure_strain=2.0), PlasticStrainLimit(2.0)),
        (Fracture(failure="spall", failure_time=1e-6), Spall(1.9e9, 1e-6)),
    ],
)
def test_failure__is_that_of_the_parameters_with_the_constants_of_the_material(
    given: Fracture, expected: object
) -> None:
    assert check_failure(given, ROLES) == []
    assert failure_of(given, COPPER) == expected


@pytest.mark.parametrize(
    ("given", "field"),
    [
        (Fracture(failure="plastic-strain"), "failure_strain"),
        (Fracture(failure="spall"), "failure_time"),
        (Fracture(failure_strain=1.0), "failure_strain"),
        (Fracture(failure="plastic-strain", failure_strain=1.0, failure_time=1e-6), "failure_time"),
    ],
)
def test_failure__is_refused_with_a_number_too_few_or_too_many(given: Fracture, field: str) -> None:
    findings = check_failure(given, ROLES)
    assert [finding.field for finding in findings] == [field]


def test_failure__by_spall_is_refused_for_a_material_without_a_spall_strength() -> None:
    given = Fracture(failure="spall", failure_time=1e-6)
    (finding,) = check_failure(given, {**ROLES, "target": THESIS})
    assert finding.field == "failure"
    assert "copper-thesis-plastic" in finding.limit
    assert "target.tension.spall_strength" in finding.cure
