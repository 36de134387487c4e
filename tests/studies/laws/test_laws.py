"""Laws: why a shot is out of range, and what they take from a shot."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from studies import laws, materials
from studies.cubes.cube import build
from studies.cubes.points import points_of
from studies.laws import SPEED, THICKNESS_RATIO, Code, RangeStatus, Reason, Shot, cour_palais
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
        for ratio, words in ((0.5, ""), (2.0, ""), (0.4, "projectile L/d"), (2.1, "projectile L/d"))
    ),
    ("charters_summers", replace(OF_COPPER, speed=17e3), "v = 17 km/s is above 16 km/s (Cour-Palais (1987)"),
    ("charters_summers", TUNGSTEN, ""),
    ("charters_summers", replace(TUNGSTEN, target=ALUMINIUM), "rho_p/rho_t = 6.93 is above 3"),
    ("zhang_tan", replace(OF_COPPER, speed=3000.0), ""),
    ("strength_ln", Shot(6e3, 10e-3, 6e-3, ALUMINIUM, ALUMINIUM), ""),
    ("strength_ln", OF_COPPER, "t/d = 0.25 is below 0.55"),
    ("cour_palais", replace(OF_ALUMINIUM, obliquity=math.pi / 3), ""),
    ("cour_palais", replace(OF_ALUMINIUM, obliquity=STEEP), "up to 85 deg"),
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
        ("maiden_al", replace(OF_ALUMINIUM, plate_thickness=None), RangeStatus.NO_ANSWER),
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
    cylinder: dict[str, Any] = {"projectile_diameter": 5e-3, "projectile_shape": "cylinder", "projectile_length": 4e-3}
    metal = dict.fromkeys(("projectile", "target"), "copper-thesis-plastic")
    shots = [laws.shot_from({"speed": speed, **cylinder, **metal}) for speed in (4e3, 5e3, 6e3, 7e3)]
    depths = [1e3 * laws.load("charters_summers").evaluate(shot).value for shot in shots]
    assert shots[0].projectile_diameter == pytest.approx(5.31e-3, abs=5e-6)
    assert shots[0].length_ratio == pytest.approx(0.8)
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
    stated = subjects["charters_summers"].range
    assert stated is not None
    assert stated.is_stated
