"""The verification cases: each is a claim by its own sentence."""

from functools import partial

from studies import verification
from tests.claims import Claim

CLAIMS = [
    Claim(case.name, case.says, partial(case.run, verification.DEFAULT), case.quick)
    for case in map(verification.load, verification.names())
]
