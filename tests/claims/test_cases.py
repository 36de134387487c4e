"""The verification cases: each is a claim by its own sentence, and a few are ordinary tests."""

import pytest

from studies.cases import verification
from studies.cases.verification import DEFAULT, VerificationCase
from tests.claims.marked import Compared

METHODS = ("sph-", "finite-elements", "coupled-bar")  # beginnings of the cases of other methods

# Ordinary tests too; others take seconds of kernels or steps for what contracts of laws and of scenarios have as well.
ORDINARY = ("elastic-waves", "patch")


def _marked(case: VerificationCase) -> list[pytest.MarkDecorator]:
    """Its mark, and for a case of other methods that of their set too."""
    minutes = 0.0 if case.name in ORDINARY else 0.5
    sets = ["cases", *(["methods"] if case.name.startswith(METHODS) else [])]
    return [pytest.mark.claim(each, case.name, minutes=minutes, says=case.says) for each in sets]


CASES = map(verification.load, verification.names())


@pytest.mark.parametrize("case", [pytest.param(case, marks=_marked(case), id=case.name) for case in CASES])
def test_case__has_its_answer(case: VerificationCase, compared: Compared) -> None:
    for row in case.run(DEFAULT):
        compared(row)
