"""The verification cases: each is a claim by its own sentence, and most of the quick ones are ordinary tests."""

from collections.abc import Callable

import pytest

from studies.cases import verification
from studies.cases.verification import DEFAULT, VerificationCase

METHODS = ("sph-", "finite-elements", "coupled-bar")  # beginnings of the cases of other methods

# Quick, but seconds of kernels or steps for what others have too: contracts of the laws, waves and contact of bars.
ONLY_CLAIMED = (
    *("johnson-cook", "mirror", "noh-plane-axis", "plate-impact", "release", "rotation"),
    *("similarity", "sod", "velocity-boost", "vibrating-bar"),
)


def _marked(case: VerificationCase) -> list[pytest.MarkDecorator]:
    """Its mark, and for a case of other methods that of their set too."""
    minutes = 0.0 if case.quick and case.name not in ONLY_CLAIMED else 0.5
    sets = ["cases", *(["methods"] if case.name.startswith(METHODS) else [])]
    return [pytest.mark.claim(each, case.name, minutes=minutes, says=case.says) for each in sets]


CASES = map(verification.load, verification.names())


@pytest.mark.parametrize("case", [pytest.param(case, marks=_marked(case), id=case.name) for case in CASES])
def test_case__has_its_answer(case: VerificationCase, compared: Callable[..., None]) -> None:
    for row in case.run(DEFAULT):
        compared(row)
