"""The page and the picture of an answer: what they show is what the answer says."""

import re
from pathlib import Path

import pytest

from studies.answers import EXAMPLE
from studies.answers.answer import answers
from studies.answers.page import page
from studies.answers.picture import picture
from studies.answers.question import read_question
from studies.quantities.units import readable
from studies.reports.drawing.charts import draw
from studies.reports.figure import CHANCES, EVEN_CHANCE, FAILED, HELD, THIS
from studies.shields.shots.chance import probability
from studies.sweeps.document import read_yaml
from tests.studies.answers.test_answers import BLOCK, PLATE

SHIELD = read_yaml(EXAMPLE.read_text(encoding="utf-8"), EXAMPLE.name)


@pytest.mark.parametrize("asked", [SHIELD, PLATE, BLOCK], ids=["shield", "plate", "block"])
def test_page__has_headline_picture_and_every_law(asked: dict[str, str]) -> None:
    question = read_question(asked)
    [answer] = answers(question)
    html = page(answer, question.shot(question.fixed))
    assert f"<h1>{answer.headline()}</h1>" in html
    assert html.count("<svg") == 2  # wide and narrow
    for each in answer.quantities[0].laws:
        if not each.is_for_another_material:
            assert re.search(re.escape(each.law.title), html)


def test_page__prints_each_number_of_a_shot_with_its_unit() -> None:
    question = read_question(SHIELD)
    [answer] = answers(question)
    html = page(answer, question.shot(question.fixed))
    assert answer.shield is not None
    for near in answer.shield.nearest:
        row = [(near.shot.speed, "m s-1"), (near.shot.projectile_diameter, "m"), (near.shot.stand_off, "m")]
        assert all(f"<td>{readable(value, unit)}</td>" in html for value, unit in row)


def test_picture__of_a_shield_has_equations_shots_and_probabilities(tmp_path: Path) -> None:
    question = read_question(SHIELD)
    shot = question.shot(question.fixed)
    figure = picture(shot, "shield")
    series = {each.label: each for each in figure.panels[0].series}
    assert {THIS, FAILED, HELD, CHANCES, EVEN_CHANCE, "Christiansen, Whipple shield"} <= set(series)
    drawn = dict(zip(series[EVEN_CHANCE].x, series[EVEN_CHANCE].y, strict=True))
    assert {speed for speed, diameter in drawn.items() if diameter is not None} == {v for v in drawn if v < 9.89e3}
    for speed, diameter in [(speed, diameter) for speed, diameter in drawn.items() if diameter is not None][::11]:
        at = read_question({**SHIELD, "speed": f"{speed} m/s", "projectile_diameter": f"{diameter} m"})
        said = probability(at.shot(at.fixed))
        assert said is not None
        assert said.value == pytest.approx(0.5, abs=1e-3)
    assert draw(figure, tmp_path / "shield.svg").read_text(encoding="utf-8").startswith("<?xml")
