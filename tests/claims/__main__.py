"""The command that recomputes claims::

python -m tests.claims [NAME ...] [--quick] [--json FILE] [--list]
"""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterable, Sequence
from contextlib import redirect_stdout
from pathlib import Path

import pytest

from tests.claims import Claim, framework, marked

ALL_FINE, SOME_FAILED, NOTHING_TO_DO = 0, 1, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the claims that were asked for and return the exit status."""
    asked = _parser().parse_args(arguments)
    names = [name.replace("_", "-") for name in asked.names]
    every = framework.select(quick=asked.quick)
    registered = {name for claim in every for name in (claim.set, claim.name)} | set(framework.sets())
    ours = [name for name in names if name in registered]
    tests = [name for name in names if name not in registered or name in marked.known()] if names else [marked.ALL]
    claims = framework.select(ours, quick=asked.quick) if ours or not names else []
    if asked.list:
        return list_claims(claims, tests)
    return judge(claims, [] if asked.quick else tests, json_file=asked.json)


def judge(claims: Iterable[Claim], tests: Sequence[str] = (), *, json_file: Path | None = None) -> int:
    """Run claims, print each row as it is computed, and return the exit status."""
    rows = []
    for claim in claims:
        print(f"... {claim.set} {claim.name}: {claim.says}", file=sys.stderr, flush=True)
        for verified in framework.run(claim):
            print(f"{claim.name} | {verified.row} | {verified.seconds:.1f} s", flush=True)
            print(verified.trace, end="", file=sys.stderr, flush=True)
            rows.append({"set": claim.set, **verified.as_json()})
    if tests:
        status, judged = marked.judge(tests)
        if status not in (pytest.ExitCode.OK, pytest.ExitCode.TESTS_FAILED):
            return NOTHING_TO_DO
        rows += judged.rows
    if json_file:
        text = json.dumps({"claims": rows}, indent=2, allow_nan=False) + "\n"
        json_file.write_text(text, encoding="utf-8")
    counts = Counter(row["verdict"] for row in rows)
    print(f"\n{counts['REPORT']} reported and not gated")
    print(f"{counts['PASS']} passed, {counts['FAIL']} failed")
    return SOME_FAILED if counts["FAIL"] or not rows else ALL_FINE


def list_claims(claims: Sequence[Claim], tests: Sequence[str]) -> int:
    """Print set, name, minutes by name and sentence of claims, and run none."""
    with redirect_stdout(sys.stderr):
        status, judged = marked.judge(tests, "--collect-only") if tests else (pytest.ExitCode.OK, marked.Judge())
    if status != pytest.ExitCode.OK:
        return NOTHING_TO_DO
    lines = [(each.set, each.name, each.minutes, each.says) for each in claims]
    lines += [(each.set, each.name, each.minutes, each.says) for each in judged.listed]
    width = max(len(name) for _, name, _, _ in lines)
    for set_name, name, minutes, says in sorted(lines):
        print(f"{set_name}  {name:{width}}  {f'{minutes:g} min' if minutes else '':7}  {says}")
    return ALL_FINE


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
