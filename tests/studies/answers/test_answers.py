"""What laws and shots say of a shot without a run: the laws' own numbers, ranges, spread, and what is refused."""

import math
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from studies.answers.answer import answers, document
from studies.answers.cube import cube_of
from studies.answers.question import read_question
from studies.laws import Shot
from studies.quantities.findings import InvalidInput
from studies.sweeps.cost import cost_of
from studies.sweeps.sweep import Sweep
from tests.claims.rows import equal

PLATE = {
    "speed": "5.75 km/s",
    "projectile": "al-2024-t3",
    "projectile_diameter": "10 mm",
    "target": "copper-ofhc",
    "plate_thickness": "1.5 mm",
}
BLOCK = {"speed": "6 km/s", "projectile": "copper-ofhc", "projectile_diameter": "4.7 mm", "target": "copper-ofhc"}
SHIELD = {
    "speed": "7 km/s",
    "projectile": "al-2017-t4",
    "projectile_diameter": "5 mm",
    "bumper": "al-6061-t6",
    "bumper_thickness": "1.2 mm",
    "stand_off": "10 cm",
    "wall_thickness": "3.2 mm",
    "wall_yield_stress": "275.8 MPa",
}


@pytest.mark.parametrize("asked", [PLATE, BLOCK, SHIELD], ids=["plate", "block", "shield"])
@pytest.mark.claim("door", "laws-without-a-run", says="Every law of a target says its own value and range of a shot.")
def test_answer__is_what_each_law_says(asked: dict[str, Any], compared: Callable[..., None]) -> None:
    question = read_question(asked)
    [answer] = answers(question)
    shot = question.shot(answer.parameters)
    for quantity in answer.quantities:
        for each in quantity.laws:
            said = [each.law.evaluate(shot, variant) for variant in each.law.variants(shot)]
            finite = [one.value for one in said if not math.isnan(one.value)]
            if not finite:
                assert math.isnan(each.value)
                continue
            compared(
                equal(f"{each.law.name}: bounds (m)", expected=(min(finite), max(finite)), got=(each.low, each.high))
            )
            assert each.in_range == said[0].in_range
        trusted = [each.value for each in quantity.laws if each.in_range and each.law.use == "verdict"]
        if quantity.spread:
            assert quantity.spread[0] <= min(trusted)
            assert quantity.spread[1] >= max(trusted)
        assert len(quantity.sentence().split()) <= 20
    assert answer.target == question.target


def test_nearest_shots__are_of_the_same_metals() -> None:
    [answer] = answers(read_question(PLATE))
    assert [each.shot.value for each in answer.shots] == [0.0212]
    assert answer.shots[0].apart == pytest.approx(0.0, abs=1e-9)
    [unlike] = answers(read_question({**PLATE, "target": "steel-304"}))
    assert not unlike.shots


def test_cube__has_the_answers_over_the_axes() -> None:
    question = read_question({**SHIELD, "speed": ["3 km/s", "7 km/s"], "obliquity": ["0 deg", "45 deg"]})
    cube = cube_of(question)
    assert cube.critical_diameter.dims == ("law_of_critical_diameter", "speed", "obliquity")
    for answer in answers(question):
        at = cube.sel(speed=answer.parameters["speed"], obliquity=answer.parameters["obliquity"])
        for each in answer.quantities[0].laws:
            got = float(at.critical_diameter.sel(law_of_critical_diameter=each.law.name))
            assert got == pytest.approx(each.value, nan_ok=True)
    plain = document(question)
    assert len(plain["items"]) == 4
    for item in plain["items"]:
        at = cube.sel({axis.name: item["parameters"][axis.name] for axis in question.axes})
        for safe in item["shield"]["safe"]:
            where = {"risk": safe["risk"]} if safe["risk"] else {"law_of_critical_diameter": safe["law"]}
            name = f"safe_{safe['size']}_by_{'risk' if safe['risk'] else 'law'}"
            got = at[name].sel(where).item()
            assert got == safe["value"] or (math.isnan(got) and safe["value"] is None)
            assert at[f"{name}_reason"].sel(where).item() == (safe["reason"] or "")
        assert at.probability.item() == item["shield"]["probability"]["value"]
    assert plain["laws"]["whipple_nno"]["source"]


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"speed": "60 km/s"}, "speed"),
        ({"projectle": "al-2017-t4"}, "projectle"),
        ({"bumper": "al-6061"}, "bumper"),
        ({"target": "al-6061-t6"}, "target"),
        ({"projectile_diameter": ["3 mm", "5"]}, "projectile_diameter[1]"),
        ({"stand_off": None}, "stand_off"),
        ({"further_bumpers": [{"bumper_thickness": "1 mm"}]}, "bumper_2_stand_off"),
        ({"further_bumpers": [{"thickness": "1 mm"}]}, "further_bumpers[0].thickness"),
        ({"further_bumpers": 4 * [{"bumper_thickness": "1 mm"}]}, "further_bumpers"),
        (
            {"wall": "soft", "wall_yield_stress": None, "materials": {"soft": {"base": "lead", "yield_stresses": []}}},
            "wall",
        ),
        ({"speed": {"start": "2 km/s", "stop": "12 km/s", "step": "1 m/s"}}, "speed"),
        ({"materials": []}, "materials"),
    ],
)
def test_question__that_cannot_be_asked_is_refused_by_field(change: dict[str, Any], field: str) -> None:
    with pytest.raises(InvalidInput) as raised:
        read_question({**SHIELD, **change})
    assert field in [finding.field for finding in raised.value.findings]


@pytest.mark.parametrize(
    ("former", "word"),
    [
        *(("target", "bumper"), ("plate_thickness", "bumper_thickness"), ("inner_thickness", "bumper_2_thickness")),
        *(("standoff", "stand_off"), ("spacing", "stand_off"), ("rear_wall", "wall")),
    ],
)
def test_shield__in_other_words_is_refused_with_its_own(former: str, word: str) -> None:
    fixed = {name: value for name, value in SHIELD.items() if name not in (word, "wall_yield_stress")} | {former: "x"}
    sweep = {"scenario": "whipple_shield", "fixed": fixed, "axes": {"speed": ["7 km/s"]}, "resolution": 16}
    for read, asked in ((read_question, fixed), (Sweep.parse, sweep)):
        with pytest.raises(InvalidInput) as raised:
            read(asked)
        cures = {finding.field.removeprefix("fixed."): finding.cure for finding in raised.value.findings}
        assert cures[former] == f"write {word}, not {former}"


def test_shield__as_a_shot_and_as_a_sweep_is_one_document() -> None:
    """A shot with a resolution runs as a sweep, and a sweep is answered, with a list of further bumpers too."""
    second = {"bumper": "al-2024-t3", "bumper_thickness": "0.5 mm", "stand_off": "4 cm"}
    shield = {name: value for name, value in SHIELD.items() if name != "wall_yield_stress"} | {"wall": "al-6061-t6"}
    for shot in (shield, {**shield, "further_bumpers": [second]}, {**shield, "speed": ["5 km/s", "7 km/s"]}):
        sweep = Sweep.parse({**shot, "resolution": 16, "failure": "void-growth"})
        assert [*sweep.shots()] == [*_shots(shot)] == [*_shots(sweep.document())]
        assert [*_shots({**shot, "resolution": 16})] == [*_shots(shot)]
        assert cost_of(sweep).runs == len(sweep.runs())
    search = {"projectile_diameter": {"limit_of": "wall_perforated", "between": ["3 mm", "9 mm"], "until": "10 %"}}
    searched: dict[str, Any] = {"scenario": "whipple_shield", "fixed": shield, "axes": search}
    assert [shot.projectile_diameter for shot in _shots(searched)] == [3e-3, 9e-3]
    for key, value in {"combine": "zip", "fixed": [], "scenario": None}.items():
        with pytest.raises(InvalidInput):
            read_question({**searched, key: value})


def _shots(document: dict[str, Any]) -> Iterator[Shot]:
    question = read_question(document)
    return map(question.shot, question.points())


def test_question__knows_own_materials() -> None:
    own = {"mine": {"base": "al-6061-t6", "title": "Mine", "brinell_hardness": {"value": 80, "unit": "1"}}}
    question = read_question({**PLATE, "target": "mine", "materials": own})
    [answer] = answers(question)
    assert question.shot(answer.parameters).brinell_hardness == 80
