"""A question about a shield: what is refused, the numbers of its dataset and its page, and the picture."""

import json
import math
from typing import Any

import pytest

from studies.answers.answer import document
from studies.answers.cube import cube_of
from studies.answers.question import read_question
from studies.quantities.findings import InvalidInput
from studies.sweeps.cost import cost_of
from studies.sweeps.sweep import Sweep
from tests.studies.answers.test_answers import shots_of
from tests.studies.shields.samples import QUESTION


def test_cube__has_the_probability_and_the_safe_sizes_over_the_axes() -> None:
    question = read_question({**QUESTION, "speed": ["3 km/s", "7 km/s"], "obliquity": ["0 deg", "45 deg"]})
    cube, items = cube_of(question), json.loads(json.dumps(document(question)))["items"]
    assert len(items) == 4
    for item in items:
        at = cube.sel({axis.name: item["parameters"][axis.name] for axis in question.axes})
        for safe in item["shield"]["safe"]:
            where = {"risk": safe["risk"]} if safe["risk"] else {"critical_diameter_law": safe["law"]}
            name = f"safe_{safe['size']}_by_{'risk' if safe['risk'] else 'law'}"
            got = at[name].sel(where).item()
            assert got == safe["value"] or (math.isnan(got) and safe["value"] is None)
            assert at[f"{name}_reason"].sel(where).item() == (safe["reason"] or "")
        assert at.probability.item() == item["shield"]["probability"]["value"]


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"bumper": "al-6061"}, "bumper"),
        ({"target": "al-6061-t6"}, "target"),
        ({"stand_off": None}, "stand_off"),
        ({"further_bumpers": [{"bumper_thickness": "1 mm"}]}, "bumper_2_stand_off"),
        ({"further_bumpers": [{"thickness": "1 mm"}]}, "further_bumpers[0].thickness"),
        ({"further_bumpers": 4 * [{"bumper_thickness": "1 mm"}]}, "further_bumpers"),
        (
            {"wall": "soft", "wall_yield_stress": None, "materials": {"soft": {"base": "lead", "yield_stresses": []}}},
            "wall",
        ),
    ],
)
def test_shield__that_cannot_be_asked_about_is_refused_by_field(change: dict[str, Any], field: str) -> None:
    with pytest.raises(InvalidInput) as raised:
        read_question({**QUESTION, **change})
    assert field in [finding.field for finding in raised.value.findings]


@pytest.mark.parametrize(
    ("former", "word"), [("target", "bumper"), ("inner_thickness", "bumper_2_thickness"), ("standoff", "stand_off")]
)
def test_shield__in_other_words_is_refused_with_its_own(former: str, word: str) -> None:
    fixed = {name: value for name, value in QUESTION.items() if name not in (word, "wall_yield_stress")} | {former: "x"}
    with pytest.raises(InvalidInput) as raised:
        Sweep.parse({"scenario": "whipple_shield", "fixed": fixed, "axes": {"speed": ["7 km/s"]}, "resolution": 16})
    cures = {finding.field.removeprefix("fixed."): finding.cure for finding in raised.value.findings}
    assert cures[former] == f"write {word}, not {former}"


def test_shield__as_a_shot_and_as_a_sweep_is_one_document() -> None:
    """A shot with a resolution runs as a sweep, and a sweep is answered, with a list of further bumpers too."""
    second = {"bumper": "al-2024-t3", "bumper_thickness": "0.5 mm", "stand_off": "4 cm"}
    shield = {name: value for name, value in QUESTION.items() if name != "wall_yield_stress"} | {"wall": "al-6061-t6"}
    for shot in (shield, {**shield, "further_bumpers": [second]}, {**shield, "speed": ["5 km/s", "7 km/s"]}):
        sweep = Sweep.parse({**shot, "resolution": 16, "failure": "void-growth"})
        assert [*sweep.shots()] == [*shots_of(shot)] == [*shots_of(sweep.document())]
        assert [*shots_of({**shot, "resolution": 16})] == [*shots_of(shot)]
        assert cost_of(sweep).runs == len(sweep.runs())
    search = {"projectile_diameter": {"limit_of": "wall_perforated", "between": ["3 mm", "9 mm"], "until": "10 %"}}
    searched: dict[str, Any] = {"scenario": "whipple_shield", "fixed": shield, "axes": search}
    assert [shot.projectile_diameter for shot in shots_of(searched)] == [3e-3, 9e-3]
