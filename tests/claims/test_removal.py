"""Each feature can be taken away: what is left computes, serves and passes the tests that all share."""

import pytest

from tests.claims.marked import Compared
from tests.claims.removal import Tried, without
from tests.claims.rows import equal
from tests.contracts.features import features


@pytest.mark.parametrize(
    "feature",
    [pytest.param(name, marks=pytest.mark.claim("removal", f"without-{name}", minutes=5.0)) for name in features()],
)
def test_feature__can_be_taken_away(feature: str, compared: Compared) -> None:
    """The tree without a feature lists what it has, computes a small sweep, starts the service and passes its tests."""

    def report(step: Tried) -> None:
        text = f"without {feature}: {step.name} ({step.last})"
        compared(equal(text, expected=True, got=step.passed))

    without(feature, report)
