"""Critical diameters of Whipple shields: continuous over the speed, less behind bumpers that are too thin."""

import math
from dataclasses import replace

import numpy as np
import pytest

from studies import laws, materials
from studies.laws import Shield, Shot, whipple_jsc, whipple_nno, whipple_reimerdes

ALUMINIUM = materials.load("al-6061-t6")
SHIELD = Shield(1.2e-3, 3.2e-3, 0.1, 276e6)
DENSITIES = (2703.0, 2703.0)
EQUATIONS = pytest.mark.parametrize("equation", [whipple_nno, whipple_jsc, whipple_reimerdes])


def shot(shield: Shield | None = SHIELD) -> Shot:
    return Shot(7e3, 5e-3, SHIELD.bumper_thickness, ALUMINIUM, ALUMINIUM, shield=shield)


@EQUATIONS
def test_critical_diameter__has_no_jump(equation: object) -> None:
    speeds = np.linspace(1e3, 14e3, 5201)
    diameters = equation.critical_diameter(speeds, *DENSITIES, SHIELD)  # type: ignore[attr-defined]
    assert np.abs(np.diff(diameters)).max() < 0.01 * diameters.min()


@pytest.mark.parametrize("equation", [whipple_jsc, whipple_reimerdes])
def test_thin_bumper__stops_less_and_a_thick_one_as_much_as_by_christiansen(equation: object) -> None:
    for thickness, less in ((0.2e-3, True), (3e-3, False)):
        shield = replace(SHIELD, bumper_thickness=thickness)
        mine = equation.critical_diameter(9e3, *DENSITIES, shield)  # type: ignore[attr-defined]
        thick = whipple_nno.critical_diameter(9e3, *DENSITIES, shield)
        assert (mine < 0.9 * thick) if less else mine == pytest.approx(thick)


def test_critical_diameter__beyond_65_degrees_is_that_at_65() -> None:
    oblique, steeper = (
        whipple_nno.critical_diameter(9e3, *DENSITIES, SHIELD, math.radians(angle)) for angle in (65.0, 80.0)
    )
    normal = whipple_nno.critical_diameter(9e3, *DENSITIES, SHIELD)
    assert oblique == steeper
    assert oblique > normal


@pytest.mark.parametrize("name", [law.name for law in laws.answering("critical_diameter")])
def test_law_of_shields__has_no_value_without_a_shield(name: str) -> None:
    law = laws.load(name)
    assert law.evaluate(shot()).in_range
    answer = law.evaluate(shot(None))
    assert math.isnan(answer.value)
    assert answer.reason == "the target is no Whipple shield"
