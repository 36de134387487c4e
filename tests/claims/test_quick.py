"""The quick claims as tests, one a claim; the others run with ``make claims``."""

import pytest

from tests.claims import Claim, framework
from tests.claims.framework import Word


@pytest.mark.claim
@pytest.mark.parametrize("one", framework.select(quick=True), ids=lambda one: one.name)
def test_quick_claim__holds(one: Claim) -> None:
    verdicts = list(framework.run(one))
    failed = [verdict for verdict in verdicts if verdict.word is Word.FAIL]
    assert not failed, "\n" + framework.table(verdicts) + "\n" + failed[0].trace
