"""Problems with an exact answer: each is a claim by its own sentence, and a few are ordinary tests."""

import pytest

from tests.cases.verification import DEFAULT, VerificationCase, cases
from tests.claims.marked import Compared

METHODS = ("sph-", "finite-elements", "coupled-bar")  # beginnings of the cases of other methods

# Ordinary tests too; others take seconds of kernels or steps for what contracts of laws and of scenarios have as well.
ORDINARY = ("elastic-waves", "patch")


def _marked(case: VerificationCase) -> list[pytest.MarkDecorator]:
    """Its mark, and for a case of other methods that of their set too."""
    minutes = 0.0 if case.name in ORDINARY else 0.5
    sets = ["cases", *(["methods"] if case.name.startswith(METHODS) else [])]
    return [pytest.mark.claim(name, case.name, minutes=minutes, says=case.says) for name in sets]


@pytest.mark.parametrize("case", [pytest.param(case, marks=_marked(case), id=case.name) for case in cases().values()])
def test_case__has_its_answer(case: VerificationCase, compared: Compared) -> None:
    for row in case.run(DEFAULT):
        compared(row)


@pytest.mark.parametrize("case", cases().values(), ids=lambda case: case.name)
def test_case__names_its_sentence_and_its_source(case: VerificationCase) -> None:
    assert case.says
    assert case.source
