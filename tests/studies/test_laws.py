"""Laws: printed numbers, the physical limit of Eq. 1-4, an answer for each stated yield stress."""

import math
from types import SimpleNamespace

import pytest

from studies import laws, materials
from studies.errors import InvalidInput
from studies.laws import Shot
from studies.laws.zhang_tan import hole_ratio, smallest_speed

COPPER = materials.load("copper-ofhc")
ALUMINIUM = materials.load("al-2024-t3")


def copper_shot(speed: float, thickness: float = 2e-3) -> Shot:
    return Shot(speed, 8e-3, thickness, COPPER, COPPER)


def test_laws__are_the_ones_of_the_first_light() -> None:
    assert laws.names() == [
        "charters_summers",
        "crater_two_thirds",
        "maiden_al",
        "maiden_c",
        "strength_ln",
        "zhang_tan",
    ]


def test_load__of_an_unknown_law_gives_the_nearest() -> None:
    with pytest.raises(InvalidInput, match="maiden_al"):
        laws.load("maiden_all")


def test_answering__finds_the_laws_of_a_quantity() -> None:
    depth = [law.name for law in laws.answering("crater_depth")]
    assert depth == ["charters_summers", "crater_two_thirds"]


def test_zhang_tan__meets_the_projectile_at_its_smallest_speed() -> None:
    assert float(hole_ratio(smallest_speed(0.25), 0.25)) == pytest.approx(1.0, rel=1e-12)


def test_zhang_tan__is_nan_with_the_reason_below_its_limit() -> None:
    answer = laws.load("zhang_tan").evaluate(copper_shot(2000.0))
    assert math.isnan(answer.value)
    assert "2.45 km/s" in answer.reason


def test_zhang_tan__answers_in_range_above_its_limit() -> None:
    answer = laws.load("zhang_tan").evaluate(copper_shot(3000.0))
    assert answer.in_range
    assert answer.value / 8e-3 == pytest.approx(1.174, abs=5e-4)


def test_zhang_tan__below_one_kilometre_per_second_is_nan_in_the_bare_formula() -> None:
    assert math.isnan(float(hole_ratio(900.0, 0.25)))


def test_strength_ln__has_a_variant_for_each_stated_yield_stress() -> None:
    law = laws.load("strength_ln")
    assert list(law.variants(copper_shot(6000.0))) == [
        "Y = 240 MPa",
        "Y = 157 MPa",
        "Y = 120 MPa",
        "Y = 90 MPa",
    ]
    low, high = law.band(copper_shot(6000.0))
    assert (low / 8e-3, high / 8e-3) == pytest.approx((4.138, 4.962), abs=5e-4)


def test_strength_ln__is_in_range_at_its_calibration_alone() -> None:
    law = laws.load("strength_ln")
    shot = Shot(6000.0, 10e-3, 6e-3, ALUMINIUM, ALUMINIUM)
    assert law.evaluate(shot, "Y = 345 MPa").in_range
    assert not law.evaluate(copper_shot(6000.0), "Y = 240 MPa").in_range


def test_maiden_al__on_copper_answers_and_is_flagged() -> None:
    answer = laws.load("maiden_al").evaluate(copper_shot(6000.0))
    assert answer.value / 8e-3 == pytest.approx(1.971, abs=5e-4)
    assert not answer.in_range
    assert "aluminium" in answer.reason


def test_like_on_like__flags_other_pairs() -> None:
    shot = Shot(6000.0, 8e-3, 2e-3, ALUMINIUM, COPPER)
    answer = laws.load("maiden_c").evaluate(shot)
    assert "aluminium on copper" in answer.reason


def test_range__includes_its_own_bound() -> None:
    assert laws.load("maiden_c").evaluate(copper_shot(8000.0)).in_range
    assert not laws.load("maiden_c").evaluate(copper_shot(8001.0)).in_range


def test_crater_depth__of_the_copper_benchmark() -> None:
    """0.5 g sphere at 6 km/s: 14 mm in Ma (2005), Table 3.3; Charters and Summers 14.3 mm."""
    shot = Shot(6000.0, 4.746e-3, None, COPPER, COPPER)
    depths = {law.name: law.evaluate(shot).value for law in laws.answering("crater_depth")}
    assert depths["crater_two_thirds"] == pytest.approx(14.0e-3, abs=5e-5)
    assert depths["charters_summers"] == pytest.approx(14.3e-3, abs=5e-5)


def test_shot_of__takes_the_equivalent_sphere_of_a_cylinder() -> None:
    """5 mm by 4 mm: 5.31 mm, and depths 12.2, 14.2, 16.0, 17.8 mm after Charters and Summers."""
    resolved = materials.load("copper-thesis-plastic").resolved()
    law = laws.load("charters_summers")
    depths = []
    for speed in (4e3, 5e3, 6e3, 7e3):
        run = SimpleNamespace(
            parameters={
                "speed": speed,
                "projectile_diameter": 5e-3,
                "projectile_shape": "cylinder",
                "projectile_length": 4e-3,
            },
            materials={"projectile": resolved, "target": resolved},
        )
        shot = laws.shot_of(run)
        depths.append(law.evaluate(shot).value * 1e3)
    assert shot.projectile_diameter == pytest.approx(5.31e-3, abs=5e-6)
    assert depths == pytest.approx([12.2, 14.2, 16.0, 17.8], abs=0.06)
