"""Laws: why a shot is out of range, what they take from a shot, and shields of any bumper."""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from studies import laws, materials
from studies.cubes.cube import build
from studies.cubes.points import points_of
from studies.laws import (
    SPEED,
    THICKNESS_RATIO,
    Code,
    FurtherBumper,
    RangeStatus,
    Reason,
    Shield,
    Shot,
    cour_palais,
    whipple_jsc,
    whipple_nno,
    whipple_nno_modified,
    whipple_reimerdes,
    whipple_srl,
)
from studies.laws._words import LIMITS, REASONS
from studies.reports.judgement import judgements_of
from studies.reports.matched import matched_observations
from studies.sweeps import examples
from studies.sweeps.document import read_sweep_file
from studies.sweeps.sweep import Sweep

COPPER, ALUMINIUM = materials.load("copper-ofhc"), materials.load("al-2024-t3")
OF_COPPER = Shot(6e3, 8e-3, 2e-3, COPPER, COPPER)
OF_ALUMINIUM = Shot(6e3, 8e-3, 2e-3, ALUMINIUM, ALUMINIUM)
SOFT = replace(OF_ALUMINIUM, target=replace(ALUMINIUM, brinell_hardness=None))
TUNGSTEN = replace(OF_COPPER, projectile=materials.load("tungsten"))
STEEP = math.radians(86.0)
SHIELD = Shield(1.2e-3, 3.2e-3, 0.1, 276e6)
DENSITIES = (2703.0, 2703.0)
THREE_WALLS = replace(SHIELD, stand_off=0.05, further_bumpers=(FurtherBumper(1e-3, 0.05),))
TWO_WALLS = [law.name for law in laws.answering("critical_diameter") if law.name != "whipple_srl_three_walls"]

# Law, shot, and words of the reason why it is out of range; none where it is inside.
RANGES: list[tuple[str, Shot, str]] = [
    ("maiden_al", OF_COPPER, "calibrated on aluminium, the target is copper"),
    ("maiden_al", replace(OF_ALUMINIUM, speed=9e3), "v = 9 km/s is above 8 km/s (source not found)"),
    ("maiden_c", replace(OF_COPPER, speed=8000.0), ""),
    ("maiden_c", replace(OF_COPPER, speed=8001.0), "above 8 km/s"),
    ("maiden_c", replace(OF_COPPER, projectile=ALUMINIUM), "aluminium on copper"),
    *((law, replace(OF_ALUMINIUM, speed=1000.0), "") for law in ("maiden_al", "maiden_c")),
    *(
        (law, replace(OF_COPPER, length_ratio=ratio), words)
        for law in ("maiden_c", "charters_summers")
        for ratio, words in ((0.5, ""), (2.0, ""), (0.4, "projectile L/d"), (50.0, "projectile L/d"))
    ),
    (
        "charters_summers",
        replace(OF_COPPER, speed=17e3),
        "v = 17 km/s is above 16 km/s (Cour-Palais (1987), Int. J. Impact Eng. 5, p. 225)",
    ),
    ("charters_summers", TUNGSTEN, ""),
    ("charters_summers", replace(TUNGSTEN, target=ALUMINIUM), "rho_p/rho_t = 6.93 is above 3"),
    ("zhang_tan", replace(OF_COPPER, speed=3000.0), ""),
    ("strength_ln", Shot(6e3, 10e-3, 6e-3, ALUMINIUM, ALUMINIUM), ""),
    ("strength_ln", OF_COPPER, "t/d = 0.25 is below 0.55"),
    ("cour_palais", replace(OF_ALUMINIUM, obliquity=math.pi / 3), ""),
    ("cour_palais", replace(OF_ALUMINIUM, obliquity=STEEP), "up to 85 deg"),
    *((law, replace(OF_ALUMINIUM, shield=SHIELD), "") for law in TWO_WALLS),
    ("whipple_srl_three_walls", replace(OF_ALUMINIUM, shield=THREE_WALLS), ""),
    ("whipple_reimerdes", replace(OF_ALUMINIUM, shield=SHIELD, obliquity=0.5), "for normal impact"),
]
# The same where the law has no value.
MEANINGLESS: list[tuple[str, Shot, str]] = [
    *(
        (law, replace(OF_ALUMINIUM, speed=400.0), "narrower than the projectile")
        for law in ("maiden_al", "maiden_c", "strength_ln")
    ),
    *((law, replace(OF_ALUMINIUM, speed=2e3, plate_thickness=1e-4), "narrower") for law in ("maiden_al", "maiden_c")),
    *(
        (law, replace(OF_ALUMINIUM, plate_thickness=None), "t/d is not defined for this shot")
        for law in ("maiden_al", "maiden_c")
    ),
    ("zhang_tan", replace(OF_COPPER, speed=2000.0), "2.45 km/s"),
    *(
        (law, SOFT, "the material al-2024-t3 states no Brinell hardness")
        for law in ("cour_palais", "herrmann_jones", "perforation_al")
    ),
    *((law, OF_ALUMINIUM, "the target is no Whipple shield") for law in TWO_WALLS),
    *((law, replace(OF_ALUMINIUM, shield=THREE_WALLS), "the shield has a second bumper") for law in TWO_WALLS),
    ("whipple_srl_three_walls", replace(OF_ALUMINIUM, shield=SHIELD), "no shield of two bumpers and a wall"),
]


@pytest.mark.parametrize(("name", "shot", "words"), [*RANGES, *MEANINGLESS])
def test_law__says_why_a_shot_is_out_of_its_range(name: str, shot: Shot, words: str) -> None:
    law = laws.load(name)
    answer = law.evaluate(shot, law.variants(shot)[0])
    assert words in laws.in_words(answer.reasons)
    assert answer.in_range == (not answer.reasons) == (words == "")
    assert math.isnan(answer.value) == ((name, shot, words) in MEANINGLESS)


@pytest.mark.parametrize(
    ("name", "shot", "status"),
    [
        ("maiden_c", OF_COPPER, RangeStatus.INSIDE),
        ("maiden_c", replace(OF_COPPER, speed=9e3), RangeStatus.OUTSIDE_RANGE),
        ("maiden_al", replace(OF_COPPER, speed=9e3), RangeStatus.OTHER_MATERIAL),
        ("whipple_nno", replace(OF_ALUMINIUM, shield=replace(SHIELD, wall_family="steel")), RangeStatus.OTHER_MATERIAL),
        ("whipple_nno", OF_ALUMINIUM, RangeStatus.NO_ANSWER),
    ],
)
def test_answer__has_a_status(name: str, shot: Shot, status: RangeStatus) -> None:
    assert laws.load(name).evaluate(shot).status is status


def test_reason__has_code_number_bounds_and_source() -> None:
    [reason] = laws.load("crater_two_thirds").evaluate(replace(OF_COPPER, speed=8e3)).reasons
    assert reason == Reason(Code.BETWEEN, "v", 8e3, 4e3, 7e3, "m s-1", source="Ma (2005), Table 3.4")


@pytest.mark.parametrize(
    ("name", "symbol", "bounds"),
    [
        ("crater_two_thirds", SPEED, (4e3, 7e3)),
        ("strength_ln", THICKNESS_RATIO, (0.55, 0.65)),
        ("cour_palais", SPEED, (0.0, 8e3)),
        ("sawle", SPEED, (math.nan, math.nan)),  # commonly quoted, in no source
    ],
)
def test_range__has_the_bounds_that_a_source_states(name: str, symbol: str, bounds: tuple[float, float]) -> None:
    assert laws.load(name).range.bounds(symbol) == pytest.approx(bounds, nan_ok=True)


def test_code__has_words() -> None:
    assert {*LIMITS, *REASONS, Code.BETWEEN} == {*REASONS, Code.BETWEEN, Code.STATED} == {*Code}


def test_cour_palais__takes_the_normal_speed_and_another_exponent_for_dense_projectiles() -> None:
    law = laws.load("cour_palais")
    normal, oblique = replace(OF_ALUMINIUM, speed=3e3), replace(OF_ALUMINIUM, obliquity=math.pi / 3)
    assert law.evaluate(oblique).value == pytest.approx(law.evaluate(normal).value)
    like, denser, dense = cour_palais.depth_ratio(6e3, 1e-2, np.array([1.0, 1.44, 4.0]), 5e3, 100.0)
    assert denser / like == pytest.approx(1.2)
    assert dense / like == pytest.approx(4.0 ** (2.0 / 3.0))


# ---- shots ---------------------------------------------------------------------------------------


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


def test_law__is_not_judged_by_the_shot_that_its_constant_is_fitted_to() -> None:
    cube = points_of(build(Sweep.parse(read_sweep_file(Path(examples.folder()) / "sphere.yaml")), {}))
    shots = list(matched_observations(cube, "crater_depth"))
    judgements, _ = judgements_of(cube, "crater_depth", shots)
    subjects = {each.law: each for each in judgements if each.reference == "observation"}
    copper = next(number for number, shot in enumerate(shots) if shot.at.get("target", "copper-ofhc") == "copper-ofhc")
    own, other = (subjects[name].points[copper] for name in ("crater_two_thirds", "charters_summers"))
    assert (own.state, own.status) == ("unjudged", RangeStatus.FITTED)
    assert other.state == "judged"
    assert subjects["charters_summers"].range.is_stated


# ---- shields -------------------------------------------------------------------------------------


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


@pytest.mark.parametrize("equation", [whipple_nno, whipple_nno_modified, whipple_jsc])
def test_critical_diameter__beyond_65_degrees_is_that_at_65(equation: Any) -> None:
    oblique, steeper = (
        equation.critical_diameter(9e3, *DENSITIES, SHIELD, math.radians(angle)) for angle in (65.0, 80.0)
    )
    normal = equation.critical_diameter(9e3, *DENSITIES, SHIELD)
    assert oblique == steeper
    assert oblique > normal


def test_oblique_impact__behind_a_thick_bumper_is_that_of_christiansen_from_7_km_s_of_the_normal_speed() -> None:
    shield = replace(SHIELD, bumper_thickness=3e-3)
    for angle in (0.0, 30.0, 60.0):
        shot = 7.5e3 / math.cos(math.radians(angle)), *DENSITIES, shield, math.radians(angle)
        assert whipple_jsc.critical_diameter(*shot) == pytest.approx(whipple_nno.critical_diameter(*shot))


def test_modified_equation__joins_its_branches_and_takes_the_density_of_the_wall() -> None:
    """k_h meets 1.35 at 0.126, and d grows with rho_w^(2/3)."""
    bumpers = 1e-2 * 0.126 * 0.32 ** (2.0 / 3.0) * 10.0**0.5 * np.array([1.0 - 1e-9, 1.0, 2.0])
    shields = [replace(SHIELD, bumper_thickness=bumper) for bumper in bumpers]
    thin, thick, thicker = (whipple_nno_modified.critical_diameter(9e3, *DENSITIES, shield) for shield in shields)
    assert thin == pytest.approx(thick, rel=1e-3)
    assert thick == thicker
    heavy = replace(shields[1], wall_density=8.0 * DENSITIES[0])
    assert whipple_nno_modified.critical_diameter(9e3, *DENSITIES, heavy) == pytest.approx(4.0 * thick)


@pytest.mark.parametrize(("ratio", "speed"), [(0.1, 1.436 * 0.1 ** (-1 / 3)), (0.159, 2.6506), (0.16, 2.6), (0.4, 2.6)])
def test_jsc__begins_to_shatter_at_the_speed_of_the_bumper_over_the_diameter(ratio: float, speed: float) -> None:
    """Ryan and Christiansen (2011): 1.436 (t_b/d)^(-1/3) km/s, and 2.60 km/s from t_b/d = 0.16 on."""
    assert whipple_jsc._shatter_speed(ratio) == pytest.approx(speed, rel=1e-4)


def test_srl__takes_other_exponents_between_45_and_65_degrees() -> None:
    """delta = 4/3 up to 45 deg and from 65 deg on, 5/4 between: at the same speed d cos^delta stays."""
    normal = whipple_srl.critical_diameter(20e3, *DENSITIES, SHIELD)
    for angle, exponent in ((45.0, 4.0 / 3.0), (50.0, 5.0 / 4.0), (65.0, 4.0 / 3.0)):
        oblique = whipple_srl.critical_diameter(20e3, *DENSITIES, SHIELD, math.radians(angle))
        assert oblique * math.cos(math.radians(angle)) ** exponent == pytest.approx(normal)
