"""The page and the picture of an answer: what they show is what the answer says."""

import re

import pytest

from studies.answers.answer import answers
from studies.answers.page import page
from studies.answers.question import read_question
from tests import samples
from tests.studies.answers.test_answers import BLOCK, PLATE


@pytest.mark.parametrize("asked", [PLATE, BLOCK, *samples.offered("QUESTION")])
def test_page__has_headline_picture_and_every_law(asked: dict[str, str]) -> None:
    question = read_question(asked)
    [answer] = answers(question)
    html = page(answer, question.shot(question.fixed))
    assert f"<h1>{answer.headline()}</h1>" in html
    assert html.count("<svg") == 2  # wide and narrow
    for each in answer.quantities[0].laws:
        if not each.is_for_another_material:
            assert re.search(re.escape(each.law.title), html)
