"""What every material must hold: a source for each number, and constants that agree."""

import math

import pytest

from studies import materials
from studies.materials import Material
from studies.materials.schema import CONFIDENCES

# rho0 c0^2 is the bulk modulus at zero pressure; Ma (2005) alone has 3.6 and 3.94 km/s for copper.
BULK_MODULUS_AGREEMENT = 0.15


@pytest.fixture(params=materials.names())
def material(request: pytest.FixtureRequest) -> Material:
    return materials.load(request.param)


def test_material__has_a_source_and_a_confidence_for_every_number(material: Material) -> None:
    needed = {path for path in material.paths() if material.value_at(path) is not None}
    needed |= {f"yield_stresses.{one.label}" for one in material.yield_stresses}
    assert needed <= set(material.sources)
    for quantity in material.sources.values():
        assert len(quantity.source) > 10
        assert quantity.confidence in set(CONFIDENCES) - {"user"}


def test_material__loads_from_its_own_document(material: Material) -> None:
    assert materials.load(material.document()) == material
    assert Material.from_resolved(material.resolved()) == material


def test_material__has_a_bulk_modulus_near_its_sound_speed(material: Material) -> None:
    from_sound_speed = material.density * material.eos.c0**2
    assert math.isclose(
        from_sound_speed, material.elastic.bulk_modulus, rel_tol=BULK_MODULUS_AGREEMENT
    )


def test_material__has_a_poisson_ratio_of_a_metal(material: Material) -> None:
    G, K = material.elastic.shear_modulus, material.elastic.bulk_modulus
    assert 0.2 < (3 * K - 2 * G) / (6 * K + 2 * G) < 0.48


def test_material__melts_above_its_initial_temperature(material: Material) -> None:
    melt = material.thermal.melt_temperature
    assert melt is None or melt > material.thermal.room_temperature


def test_material__states_yield_stresses_for_the_laws(material: Material) -> None:
    labels = [one.label for one in material.yield_stresses]
    assert labels
    assert len(set(labels)) == len(labels)
    assert all(one.value < material.elastic.shear_modulus for one in material.yield_stresses)
