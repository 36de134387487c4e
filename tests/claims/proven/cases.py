"""The verification cases: each is a claim by its own sentence."""

from functools import partial

from studies import verification
from tests.claims import Claim


def claims_of(*, smoothed: bool) -> list[Claim]:
    """Claims of the cases of smoothed particles, whose names begin with ``sph-``, or of all others."""
    return [
        Claim(case.name, case.says, partial(case.run, verification.DEFAULT), case.quick)
        for case in map(verification.load, verification.names())
        if case.name.startswith("sph-") == smoothed
    ]


CLAIMS = claims_of(smoothed=False)
