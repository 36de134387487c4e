"""The command that recomputes claims::

python -m tests.claims [NAME ...] [--list]
"""

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from contextlib import redirect_stdout

import pytest

from tests.claims import marked

ALL_FINE, SOME_FAILED, NOTHING_TO_DO = 0, 1, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the claims that were asked for and return the exit status."""
    asked = _parser().parse_args(arguments)
    names = [name.replace("_", "-") for name in asked.names] or [marked.ALL]
    if asked.list:
        return list_claims(names)
    status, judged = marked.judge(names)
    if status not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
        return NOTHING_TO_DO
    counts = Counter(judged.verdicts)
    print(f"\n{counts['REPORT']} reported and not gated")
    print(f"{counts['PASS']} passed, {counts['FAIL']} failed")
    return SOME_FAILED if counts["FAIL"] or status != pytest.ExitCode.OK else ALL_FINE


def list_claims(names: Sequence[str]) -> int:
    """Print set, name, minutes by name and sentence of claims, and run none."""
    with redirect_stdout(sys.stderr):
        status, judged = marked.judge(names, "--collect-only")
    if status != pytest.ExitCode.OK:
        return NOTHING_TO_DO
    width = max(len(claim.name) for claim in judged.listed)
    for claim in sorted(judged.listed, key=lambda claim: (claim.set, claim.name)):
        minutes = f"{claim.minutes:g} min" if claim.minutes else ""
        print(f"{claim.set}  {claim.name:{width}}  {minutes:7}  {claim.says}")
    return ALL_FINE


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.claims", description="Recompute what the project says about itself."
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="a claim, or a set of them; all without one")
    parser.add_argument("--list", action="store_true", help="name the claims and run none")
    return parser


if __name__ == "__main__":
    sys.exit(main())
