"""What laws and shots say of a shot without a run: the laws' own numbers, ranges, spread, and what is refused."""

import json
import math
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from studies.answers.answer import answers, document
from studies.answers.cube import cube_of
from studies.answers.question import read_question
from studies.laws import Shot
from studies.quantities.findings import InvalidInput
from tests import samples
from tests.claims.rows import equal

PLATE = {
    "speed": "5.75 km/s",
    "projectile": "al-2024-t3",
    "projectile_diameter": "10 mm",
    "target": "copper-ofhc",
    "plate_thickness": "1.5 mm",
}
BLOCK = {"speed": "6 km/s", "projectile": "copper-ofhc", "projectile_diameter": "4.7 mm", "target": "copper-ofhc"}


@pytest.mark.parametrize("asked", [PLATE, BLOCK, *samples.offered("QUESTION")])
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
    question = read_question({**PLATE, "speed": ["3 km/s", "7 km/s"], "plate_thickness": ["1 mm", "2 mm", "3 mm"]})
    cube = cube_of(question)
    assert cube.hole_diameter_by_law.dims == ("speed", "plate_thickness", "hole_diameter_law")
    for answer in answers(question):
        at = cube.sel(speed=answer.parameters["speed"], plate_thickness=answer.parameters["plate_thickness"])
        for each in answer.quantities[0].laws:
            got = float(at.hole_diameter_by_law.sel(hole_diameter_law=each.law.name))
            assert got == pytest.approx(each.value, nan_ok=True)
    plain = json.loads(json.dumps(document(question)))
    assert len(plain["items"]) == 6
    assert plain["laws"]["maiden_c"]["source"]


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"speed": "60 km/s"}, "speed"),
        ({"projectle": "al-2017-t4"}, "projectle"),
        ({"target": "al-6061"}, "target"),
        ({"projectile_diameter": ["3 mm", "5"]}, "projectile_diameter[1]"),
        ({"target": None}, "target"),
        ({"speed": {"start": "2 km/s", "stop": "12 km/s", "step": "1 m/s"}}, "speed"),
        ({"materials": []}, "materials"),
    ],
)
def test_question__that_cannot_be_asked_is_refused_by_field(change: dict[str, Any], field: str) -> None:
    with pytest.raises(InvalidInput) as raised:
        read_question({**PLATE, **change})
    assert field in [finding.field for finding in raised.value.findings]


def test_question__is_that_of_a_sweep_whose_axes_are_its_values() -> None:
    searched: dict[str, Any] = {"scenario": "thin_plate", "fixed": PLATE, "axes": {"speed": ["3 km/s", "5 km/s"]}}
    assert [shot.speed for shot in shots_of(searched)] == [3e3, 5e3]
    refused: dict[str, Any] = {"combine": "zip", "fixed": [], "scenario": None}
    for key, value in refused.items():
        with pytest.raises(InvalidInput):
            read_question({**searched, key: value})


def shots_of(document: dict[str, Any]) -> Iterator[Shot]:
    question = read_question(document)
    return map(question.shot, question.points())
