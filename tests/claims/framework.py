"""Claims, their rows and verdicts, and how a set of them is found, run and printed."""

import importlib
import json
import math
import pkgutil
import sys
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from pathlib import Path
from typing import Any

from tests.rows import Row

PACKAGE = "tests.claims"


@dataclass(frozen=True)
class Claim:
    """A sentence that the project makes about itself, with the check that recomputes it."""

    name: str  # on the command line: "thesis-deck-2"
    says: str  # the sentence
    check: Callable[[], Row | Iterable[Row]]  # computes, and yields the rows
    quick: bool = False  # a few seconds: part of the test command
    set: str = ""  # the folder it was found in, with dashes


class Word(StrEnum):
    """What is said of a row."""

    PASS = "PASS"
    FAIL = "FAIL"
    REPORT = "REPORT"


@dataclass(frozen=True)
class Verdict:
    """A row that was computed, its word, and how long it took."""

    set: str
    name: str  # of the claim
    row: Row
    seconds: float  # wall time since the row before it
    trace: str = ""  # where an exception came from

    @property
    def word(self) -> Word:
        if self.row.passed is None:
            return Word.REPORT
        return Word.PASS if self.row.passed else Word.FAIL


class UnknownClaim(LookupError):
    """Nothing answers to a name that was asked for."""


def claim(
    name: str, *, says: str, quick: bool = False
) -> Callable[[Callable[[], Row | Iterable[Row]]], Claim]:
    """Make a claim of a function that yields rows."""

    def make(check: Callable[[], Row | Iterable[Row]]) -> Claim:
        return Claim(name=name, says=says, check=check, quick=quick)

    return make


def sets() -> list[str]:
    """The names of the sets: the folders beside this file, with dashes."""
    folder = Path(__file__).parent
    return sorted(
        path.name.replace("_", "-")
        for path in folder.iterdir()
        if path.is_dir() and any(path.glob("[!_]*.py"))
    )


def load(set_name: str) -> list[Claim]:
    """The claims of one set, in the order of their files and lines."""
    if set_name not in sets():
        raise UnknownClaim(f"no set of claims is named {set_name!r}; there are: {sets()}")
    package = importlib.import_module(f"{PACKAGE}.{set_name.replace('-', '_')}")
    found: dict[str, Claim] = {}
    for module in sorted(item.name for item in pkgutil.iter_modules(package.__path__)):
        if not module.startswith(("_", "test_")):
            for one in _claims_in(importlib.import_module(f"{package.__name__}.{module}")):
                if found.setdefault(one.name, one) is not one:
                    raise ValueError(f"{module} makes the claim {one.name!r} a second time")
    return [replace(one, set=set_name) for one in found.values()]


def select(names: Sequence[str] = (), *, quick: bool = False) -> list[Claim]:
    """The claims that were named, each by itself or by its set, or all; a name that nothing answers to is refused."""
    claims = [one for name in sets() for one in load(name)]
    known = {*sets(), *(one.name for one in claims)}
    for name in names:
        if name not in known:
            raise UnknownClaim(
                f"no claim and no set of claims is named {name!r}; the sets are {', '.join(sets())}, "
                "and --list names the claims"
            )
    return [
        one
        for one in claims
        if (one.quick or not quick) and (not names or {one.name, one.set} & set(names))
    ]


def run(one: Claim) -> Iterator[Verdict]:
    """Recompute one claim, row by row; an exception is a row that failed."""
    begin = time.perf_counter()
    rows = 0
    try:
        for row in _rows(one.check()):
            if not isinstance(row, Row):
                raise TypeError(f"the claim yielded {row!r}, which is not a Row")
            now = time.perf_counter()
            yield Verdict(one.set, one.name, row, now - begin)
            begin, rows = now, rows + 1
        if rows == 0:
            raise ValueError("the claim compared nothing")
    except Exception as error:
        row = Row(one.says, "no exception", f"{type(error).__name__}: {error}", passed=False)
        yield Verdict(
            one.set, one.name, row, time.perf_counter() - begin, trace=traceback.format_exc()
        )


def table(verdicts: Sequence[Verdict]) -> str:
    """The verdicts as aligned columns."""
    head = ("claim", "expected", "got", "verdict", "seconds")
    lines = [
        (
            f"{v.name}: {v.row.claim}",
            _text(v.row.expected),
            _text(v.row.got),
            v.word,
            f"{v.seconds:.1f}",
        )
        for v in verdicts
    ]
    widths = [max(len(line[column]) for line in [head, *lines]) for column in range(len(head))]
    ruled = [head, tuple("-" * width for width in widths), *lines]
    return "\n".join(
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in ruled
    )


def one_by_one(claims: Iterable[Claim]) -> list[Verdict]:
    """Run claims, and say on stderr which, and where an exception came from."""
    verdicts: list[Verdict] = []
    for one in claims:
        print(f"... {one.set} {one.name}: {one.says}", file=sys.stderr, flush=True)
        for verdict in run(one):
            verdicts.append(verdict)
            print(verdict.trace, end="", file=sys.stderr, flush=True)
    return verdicts


def write_json(verdicts: Sequence[Verdict], file: Path) -> None:
    """The verdicts for programs: a list of objects, one a row."""
    rows = [
        {
            "set": v.set,
            "name": v.name,
            "claim": v.row.claim,
            "expected": _plain(v.row.expected),
            "got": _plain(v.row.got),
            "verdict": v.word.value,
            "seconds": round(v.seconds, 3),
        }
        for v in verdicts
    ]
    file.write_text(
        json.dumps({"claims": rows}, indent=2, allow_nan=False) + "\n", encoding="utf-8"
    )


def _claims_in(module: Any) -> list[Claim]:
    return [value for value in vars(module).values() if isinstance(value, Claim)]


def _rows(answer: Row | Iterable[Row]) -> Iterable[Row]:
    return [answer] if isinstance(answer, Row) else answer


def _text(value: Any) -> str:
    """A value as one line: numbers with six digits, anything else as it says of itself."""
    plain = _plain(value)
    text = f"{plain:.6g}" if isinstance(plain, float) else str(plain)
    return " ".join(text.split())


def _plain(value: Any) -> Any:
    """A value that JSON can hold: any number as Python's own, one that is not finite as a word."""
    if isinstance(value, bool | int | str) or value is None:
        return value
    try:
        number = float(value)
    except (TypeError, ValueError):
        return str(value)
    return number if math.isfinite(number) else str(number)
