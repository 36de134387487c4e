"""Equations of the ballistic limit: their ranges, values that were computed apart from this code, and any bumper."""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from studies import laws, materials
from studies.laws import RangeStatus, Shot
from studies.shields.laws import whipple_jsc, whipple_nno, whipple_nno_modified, whipple_reimerdes, whipple_srl
from studies.shields.shield import FurtherBumper, Shield, ShotAtShield, at_shield
from tests.claims.rows import Row, equal
from tests.studies.laws.test_laws import OF_ALUMINIUM

SHIELD = Shield(1.2e-3, 3.2e-3, 0.1, 276e6)
DENSITIES = (2703.0, 2703.0)
THREE_WALLS = replace(SHIELD, stand_off=0.05, further_bumpers=(FurtherBumper(1e-3, 0.05),))
TWO_WALLS = [law.name for law in laws.answering("critical_diameter") if law.name != "whipple_srl_three_walls"]
AT_TWO, AT_THREE = at_shield(OF_ALUMINIUM, SHIELD), at_shield(OF_ALUMINIUM, THREE_WALLS)

# Law, shot, and words of the reason why it is out of range; none where it is inside.
RANGES: list[tuple[str, Shot, str]] = [
    *((law, AT_TWO, "") for law in TWO_WALLS),
    ("whipple_srl_three_walls", AT_THREE, ""),
    ("whipple_reimerdes", replace(AT_TWO, obliquity=0.5), "for normal impact"),
]
# The same where the law has no value.
MEANINGLESS: list[tuple[str, Shot, str]] = [
    *((law, OF_ALUMINIUM, "the target is no Whipple shield") for law in TWO_WALLS),
    *((law, AT_THREE, "the shield has a second bumper") for law in TWO_WALLS),
    ("whipple_srl_three_walls", AT_TWO, "no shield of two bumpers and a wall"),
]

# Fig. 4-4 of NASA/TM-2009-214785: a bumper of 0.12 cm 10 cm before a wall of 0.32 cm and 40 ksi; 2.796 on 2.713 g/cm3.
# Critical diameters in cm, computed apart from this code.
SPEEDS = (1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14)  # km/s
WHIPPLE = "0.4580 0.2956 0.2288 0.3139 0.3989 0.4839 0.5690 0.5205 0.4486 0.3972 0.3584"
OF_FIGURE = Shield(0.12e-2, 0.32e-2, 10e-2, 40.0 / 0.145038 * 1e6)
PLAIN = materials.load("al-2024-t3")
FIGURE_DENSITIES = (2713.0, 2796.0)
SHEET, SPHERE = (PLAIN.with_value("density", density) for density in FIGURE_DENSITIES)

# Three walls: 0.13 cm, 3.8 cm before 0.2 cm, 3.8 cm before 0.32 cm of 57 ksi.
THREE = Shield(0.13e-2, 0.32e-2, 3.8e-2, 57.0 / 0.145038 * 1e6, further_bumpers=(FurtherBumper(0.2e-2, 3.8e-2),))
# NASA/TM-2009-214785, Tables 4-7 and 4-8: spheres on three walls of aluminium, 7.6 cm in all, how it is split not
# stated; outer and inner bumper, wall and diameter in cm, km/s, deg, whether the wall had a hole.
THREE_WALL_SHOTS = (
    (0.13, 0.2, 0.32, 0.71, 6.42, 45.0, True),
    (0.1, 0.2, 0.32, 0.84, 11.03, 0.0, True),
    (0.13, 0.2, 0.32, 0.67, 6.96, 45.0, False),
)


@pytest.mark.parametrize(("name", "shot", "words"), [*RANGES, *MEANINGLESS])
def test_equation__says_why_a_shot_is_out_of_its_range(name: str, shot: Shot, words: str) -> None:
    answer = laws.load(name).evaluate(shot)
    assert words in laws.in_words(answer.reasons)
    assert answer.in_range == (not answer.reasons) == (words == "")
    assert math.isnan(answer.value) == ((name, shot, words) in MEANINGLESS)


def test_answer__about_a_wall_of_another_metal_and_without_a_shield_has_a_status() -> None:
    steel = at_shield(OF_ALUMINIUM, replace(SHIELD, wall_family="steel"))
    for shot, status in ((steel, RangeStatus.OTHER_MATERIAL), (OF_ALUMINIUM, RangeStatus.NO_ANSWER)):
        assert laws.load("whipple_nno").evaluate(shot).status is status


@pytest.mark.claim("door", "shield-vectors")
def test_christiansen__has_the_values_computed_apart(compared: Callable[[Row], None]) -> None:
    """The equation of 1993 has critical diameters of a Whipple shield that were computed apart."""
    diameters = 100.0 * whipple_nno.critical_diameter(1e3 * np.array(SPEEDS, float), *FIGURE_DENSITIES, OF_FIGURE)
    got = " ".join(f"{diameter:.4f}" for diameter in diameters)
    compared(equal("Whipple shield: critical diameter (cm), 1 to 14 km/s", expected=WHIPPLE, got=got))


@pytest.mark.parametrize(
    ("name", "formula"),
    [
        *(("whipple_nno", whipple_nno), ("whipple_nno_modified", whipple_nno_modified), ("whipple_jsc", whipple_jsc)),
        *(("whipple_reimerdes", whipple_reimerdes), ("whipple_srl", whipple_srl)),
        ("whipple_srl_three_walls", whipple_srl),
    ],
)
def test_law__asks_its_formula_about_the_shot(name: str, formula: Any) -> None:
    """The formulas' own doctests have values that were computed apart."""
    shot = ShotAtShield(6e3, 5e-3, 1e-3, SPHERE, SHEET, shield=THREE if "three" in name else OF_FIGURE)
    expected = formula.critical_diameter(6e3, *FIGURE_DENSITIES, shot.shield)
    assert laws.load(name).evaluate(shot).value == pytest.approx(float(expected))


@pytest.mark.parametrize(
    ("degrees", "expected"),
    [(30.0, ".9481 .4737 .2826 .2595"), (45.0, "1.2248 .6120 .4150 .3811"), (60.0, "1.7965 .8976 .8216 .7545")],
)
def test_three_walls__hit_at_an_angle_have_the_values_computed_apart(degrees: float, expected: str) -> None:
    """Equations 65 and 66, cm, at 1, 3, 22 and 25 km/s: exponents of the cosine 4/3 and 8/3, at 60 deg 5/4 and 10/4."""
    speeds = 1e3 * np.array([1.0, 3.0, 22.0, 25.0])
    shot = speeds, *FIGURE_DENSITIES, THREE, np.radians(degrees)
    got = " ".join(f"{100.0 * diameter:.4f}".removeprefix("0") for diameter in whipple_srl.critical_diameter(*shot))
    assert got == expected


def test_three_walls__that_were_holed_are_said_to_fail__and_one_that_held_too() -> None:
    said = []
    for outer, inner, wall, diameter, speed, angle, holed in THREE_WALL_SHOTS:
        between = 0.5 * 7.6e-2
        shield = Shield(
            *(1e-2 * outer, 1e-2 * wall, between, THREE.wall_yield_stress),
            further_bumpers=(FurtherBumper(1e-2 * inner, between),),
        )
        shot = 1e3 * speed, *FIGURE_DENSITIES, shield, np.radians(angle)
        said.append((bool(1e-2 * diameter > whipple_srl.critical_diameter(*shot)), holed))
    assert said == [(True, True), (True, True), (True, False)]


@pytest.mark.parametrize("equation", [whipple_nno, whipple_nno_modified, whipple_jsc, whipple_reimerdes, whipple_srl])
def test_critical_diameter__has_no_jump(equation: Any) -> None:
    speeds = np.linspace(1e3, 14e3, 5201)
    diameters = equation.critical_diameter(speeds, *DENSITIES, SHIELD)
    assert np.abs(np.diff(diameters)).max() < 0.01 * diameters.min()


@pytest.mark.parametrize("equation", [whipple_jsc, whipple_reimerdes])
def test_thin_bumper__stops_less_and_a_thick_one_as_much_as_by_christiansen(equation: Any) -> None:
    for thickness, less in ((0.2e-3, True), (3e-3, False)):
        shield = replace(SHIELD, bumper_thickness=thickness)
        mine = equation.critical_diameter(9e3, *DENSITIES, shield)
        thick = whipple_nno.critical_diameter(9e3, *DENSITIES, shield)
        assert (mine < 0.9 * thick) if less else mine == pytest.approx(thick)
