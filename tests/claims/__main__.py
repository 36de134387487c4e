"""The command that recomputes claims::

python -m tests.claims [NAME ...] [--quick] [--json FILE] [--list]
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from pathlib import Path

from tests.claims import Claim, framework, marked
from tests.claims.framework import UnknownClaim

ALL_FINE, SOME_FAILED, NOTHING_TO_DO = 0, 1, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the claims that were asked for and return the exit status."""
    asked = _parser().parse_args(arguments)
    names = [name.replace("_", "-") for name in asked.names]
    tests = {name for set_name, claims in marked.known().items() for name in (set_name, *claims)}
    of_tests = sorted(tests & set(names) if names else tests) if not (asked.quick or asked.list) else []
    registered = [name for name in names if name not in tests or name in framework.sets()]
    try:
        claims = [] if names and not registered else framework.select(registered, quick=asked.quick)
    except UnknownClaim as error:
        print(error, file=sys.stderr)
        return NOTHING_TO_DO
    if asked.list:
        print(_listing(claims))
        return ALL_FINE
    if not claims and not of_tests:
        print("no claim was selected", file=sys.stderr)
        return NOTHING_TO_DO
    return judge(claims, of_tests, json_file=asked.json)


def judge(claims: Iterable[Claim], tests: Sequence[str] = (), *, json_file: Path | None = None) -> int:
    """Run claims, print each row as it is computed, and return the exit status."""
    rows = []
    for claim in claims:
        print(f"... {_heading(claim)}: {claim.says}", file=sys.stderr, flush=True)
        for verified in framework.run(claim):
            print(f"{claim.name} | {verified.row} | {verified.seconds:.1f} s", flush=True)
            print(verified.trace, end="", file=sys.stderr, flush=True)
            rows.append({"set": claim.set, **verified.as_json()})
    if tests:
        rows += marked.judge(tests)
    if json_file:
        text = json.dumps({"claims": rows}, indent=2, allow_nan=False) + "\n"
        json_file.write_text(text, encoding="utf-8")
    counts = Counter(row["verdict"] for row in rows)
    print(f"\n{counts['REPORT']} reported and not gated")
    print(f"{counts['PASS']} passed, {counts['FAIL']} failed")
    return SOME_FAILED if counts["FAIL"] else ALL_FINE


def _listing(claims: Sequence[Claim]) -> str:
    width = max(len(claim.name) for claim in claims)
    return "\n".join(
        f"{claim.set}  {claim.name:{width}}  {'quick' if claim.quick else '     '}  {_duration(claim):6}  {claim.says}"
        for claim in claims
    )


def _heading(claim: Claim) -> str:
    return f"{claim.set} {claim.name}" + (f" ({_duration(claim)})" if claim.minutes else "")


def _duration(claim: Claim) -> str:
    """How long a claim takes a core, where it was measured."""
    return f"{claim.minutes:g} min" if claim.minutes else ""


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.claims", description="Recompute what the project says about itself."
    )
    parser.add_argument("names", nargs="*", metavar="NAME", help="a claim, or a set of them; all without one")
    parser.add_argument("--quick", action="store_true", help="those of a few seconds only")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the rows there too")
    parser.add_argument("--list", action="store_true", help="name the claims and run none")
    return parser


if __name__ == "__main__":
    sys.exit(main())
