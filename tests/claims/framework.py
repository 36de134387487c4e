"""Claims: how a set of them is found and run."""

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

from studies.verification import Verified, timed
from tests.rows import Row

PACKAGE = "tests.claims"


@dataclass(frozen=True)
class Claim:
    """A sentence that the project makes about itself, with the check that recomputes it."""

    name: str  # on the command line: "thesis-deck-2"
    says: str  # the sentence
    check: Callable[[], Row | Iterable[Row]]  # computes, and yields the rows
    quick: bool = False  # a few seconds: part of the test command
    set: str = ""  # the folder that holds it, with dashes
    minutes: float = 0.0  # of a core, as measured once; 0: not measured, or below half a minute


class UnknownClaim(LookupError):
    """No claim and no set has the name."""


def claim(
    name: str, *, says: str, quick: bool = False, minutes: float = 0.0
) -> Callable[[Callable[[], Row | Iterable[Row]]], Claim]:
    """Make a claim of a function that yields rows."""
    return lambda check: Claim(name, says, check, quick, minutes=minutes)


def sets() -> list[str]:
    """The names of the sets: the folders beside this file, with dashes."""
    folder = Path(__file__).parent
    return sorted(
        path.name.replace("_", "-") for path in folder.iterdir() if path.is_dir() and any(path.glob("[!_]*.py"))
    )


def load(set_name: str) -> list[Claim]:
    """The claims of one set, in the order of their files and lines."""
    if set_name not in sets():
        raise UnknownClaim(f"no set of claims is named {set_name!r}; there are: {sets()}")
    package = _package(set_name)
    claims: dict[str, Claim] = {}
    for module in sorted(item.name for item in pkgutil.iter_modules(package.__path__)):
        if not module.startswith(("_", "test_")):
            for each in _claims_in(importlib.import_module(f"{package.__name__}.{module}")):
                if claims.setdefault(each.name, each) is not each:
                    raise ValueError(f"{module} makes the claim {each.name!r} a second time")
    return [replace(each, set=set_name) for each in claims.values()]


def select(names: Sequence[str] = (), *, quick: bool = False) -> list[Claim]:
    """The claims of the given names or sets, or all; raises UnknownClaim.

    A set has the claims of its folder, and those that the list ``ALSO`` of its package names from other folders.
    """
    claims = [each for name in sets() for each in load(name)]
    names = [*names, *(name for asked in names if asked in sets() for name in _also(asked))]
    for name in set(names) - {*sets(), *(each.name for each in claims)}:
        raise UnknownClaim(
            f"no claim and no set of claims is named {name!r}; the sets are {', '.join(sets())}, "
            "and --list names the claims"
        )
    return [each for each in claims if (each.quick or not quick) and (not names or {each.name, each.set} & set(names))]


def _also(set_name: str) -> list[str]:
    return list(getattr(_package(set_name), "ALSO", []))


def _package(set_name: str) -> ModuleType:
    return importlib.import_module(f"{PACKAGE}.{set_name.replace('-', '_')}")


def run(chosen: Claim) -> Iterator[Verified]:
    """Recompute one claim, row by row; an exception is a row that failed."""
    return timed(chosen.name, chosen.says, partial(_rows, chosen))


def _rows(chosen: Claim) -> Iterator[Row]:
    rows = chosen.check()
    number = 0
    for row in [rows] if isinstance(rows, Row) else rows:
        if not isinstance(row, Row):
            raise TypeError(f"the claim yielded {row!r}, which is not a Row")
        number += 1
        yield row
    if not number:
        raise ValueError("the claim compared nothing")


def _claims_in(module: Any) -> list[Claim]:
    """The claims that a module defines, by themselves or as a list named ``CLAIMS``."""
    own = [value for value in vars(module).values() if isinstance(value, Claim)]
    return own + list(getattr(module, "CLAIMS", []))
