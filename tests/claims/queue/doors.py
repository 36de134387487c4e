"""Whatever is sent to the interface: it answers as it is described, and never fails."""

from collections.abc import Iterator

from tests.claims import Row, claim
from tests.claims.computed import rows_of_tests

BODIES = 10_000
FULL = {"WHIPPLE_EXAMPLES": "60", "WHIPPLE_SEQUENCES": "60"}  # of test_openapi.py


@claim(
    "openapi",
    says="schemathesis (fixed seed, operations alone and in sequence) finds nothing against the description",
)
def openapi() -> Iterator[Row]:
    yield from rows_of_tests("tests/service/api/test_openapi.py", FULL)


@claim(
    "bodies",
    says="10 000 bodies that Hypothesis invents are accepted or refused with a reason: none fails",
)
def bodies() -> Iterator[Row]:
    yield from rows_of_tests("tests/service/api/test_bodies.py", {"WHIPPLE_BODIES": str(BODIES)})
