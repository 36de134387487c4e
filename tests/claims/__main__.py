"""The command that recomputes claims::

python -m tests.claims [NAME ...] [--quick] [--json FILE] [--list]
"""

import argparse
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from tests.claims import Claim, framework
from tests.claims.framework import UnknownClaim, Verdict, Word

ALL_FINE, SOME_FAILED, NOTHING_TO_DO = 0, 1, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the claims that were asked for, print their table, and return the exit status."""
    asked = _parser().parse_args(arguments)
    try:
        claims = framework.select(asked.names, quick=asked.quick)
    except UnknownClaim as error:
        print(error, file=sys.stderr)
        return NOTHING_TO_DO
    if not claims:
        print("no claim was selected, so nothing was shown", file=sys.stderr)
        return NOTHING_TO_DO
    if asked.list:
        print(_listing(claims))
        return ALL_FINE
    return judge(claims, json_file=asked.json)


def judge(claims: Iterable[Claim], *, json_file: Path | None = None) -> int:
    """Run claims, say what came out, and return the exit status."""
    verdicts = framework.one_by_one(claims)
    if json_file:
        framework.write_json(verdicts, json_file)
    print(framework.table(verdicts))
    print(f"\n{_count(verdicts, Word.REPORT)} reported and not gated")
    print(f"{_count(verdicts, Word.PASS)} passed, {_count(verdicts, Word.FAIL)} failed")
    return SOME_FAILED if _count(verdicts, Word.FAIL) else ALL_FINE


def _count(verdicts: Sequence[Verdict], word: Word) -> int:
    return sum(verdict.word is word for verdict in verdicts)


def _listing(claims: Sequence[Claim]) -> str:
    width = max(len(one.name) for one in claims)
    return "\n".join(
        f"{one.set}  {one.name:{width}}  {'quick' if one.quick else '     '}  {one.says}"
        for one in claims
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="python -m tests.claims", description="Recompute what the project says about itself."
    )
    parser.add_argument(
        "names", nargs="*", metavar="NAME", help="a claim, or a set of them; all without one"
    )
    parser.add_argument("--quick", action="store_true", help="those of a few seconds only")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the verdicts there too")
    parser.add_argument("--list", action="store_true", help="name the claims and run none")
    return parser


if __name__ == "__main__":
    sys.exit(main())
