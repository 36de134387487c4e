"""Errors of user input: every error names the field, the value, the limit and the cure, with the nearest names."""

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial
from itertools import islice
from types import MappingProxyType
from typing import ParamSpec, TypeVar

from solver.errors import WhippleError
from solver.registry import entries

Arguments = ParamSpec("Arguments")
Accepted = TypeVar("Accepted")

MOST_FINDINGS = 20  # of one input, where its reading stops: more than a person mends at once


@dataclass(frozen=True)
class Finding:
    """One error in an input."""

    field: str  # dotted path into the document: "axes.speed[2]"
    value: str  # what was given, as text, shortened
    limit: str  # what is allowed: "a speed between 100 m/s and 20 km/s"
    cure: str  # what to do: "write '6 km/s'"

    def __str__(self) -> str:
        return f"{self.field}: {self.value} is refused; allowed: {self.limit}; {self.cure}"


@dataclass(frozen=True)
class Doubt:
    """What speaks against a number that is allowed."""

    name: str  # of a parameter, or the dotted path of a constant
    value: str
    why: str


class InvalidInput(WhippleError):
    """An input is refused for some errors, with ``more`` that are left out and JSON ``pointers`` to their fields."""

    def __init__(
        self, findings: Iterable[Finding], *, more: int = 0, pointers: Mapping[str, str] = MappingProxyType({})
    ):
        self.findings = tuple(islice(findings, MOST_FINDINGS))
        self.more = more
        self.pointers = pointers
        super().__init__("\n".join(str(finding) for finding in self.findings))

    def __reduce__(self) -> tuple["partial[InvalidInput]", tuple[tuple[Finding, ...]]]:
        """As an error goes from one process to another."""
        return partial(type(self), more=self.more, pointers=dict(self.pointers)), (self.findings,)


class Findings(list[Finding]):
    """The errors so far; with ``MOST_FINDINGS`` errors it raises InvalidInput, which ends the reading."""

    def append(self, finding: Finding) -> None:
        super().append(finding)
        if len(self) >= MOST_FINDINGS:
            raise InvalidInput(self)

    def extend(self, findings: Iterable[Finding]) -> None:
        for finding in findings:
            self.append(finding)

    def attempt(
        self, part: Callable[Arguments, Accepted], *args: Arguments.args, **options: Arguments.kwargs
    ) -> Accepted | None:
        """What a part of an input is read as; None where it is refused, with its findings kept."""
        try:
            return part(*args, **options)
        except InvalidInput as error:
            self.extend(error.findings)
            return None

    def check(self) -> None:
        """Raise InvalidInput with the errors so far, if there are any."""
        if self:
            raise InvalidInput(self)


class MissingExtra(WhippleError):
    """Libraries that are not part of a plain installation are needed."""


def refusal(field: str, raw: object, limit: str, cure: str) -> InvalidInput:
    """The error of one finding."""
    return InvalidInput([Finding(field, shown(raw), limit, cure)])


# --- near names ------------------------------------------------------------------------------------

SHOWN_LENGTH = 60  # characters of a refused value that a person still recognises
LONGEST_NAME = 100  # characters of a text that may be meant for a name
MOST_NAMES = 200  # that are compared with it: one takes up to 30 us (2026-11)


# Words that people write for a word of a name, of parameters and materials alike.
SYNONYMS: Mapping[str, str] = {
    "alu": "al",
    "aluminium": "al",
    "aluminum": "al",
    "angle": "obliquity",
    "block": "thick",
    "bullet": "projectile",
    "coarse": "draft",
    "crater": "thick",
    "cu": "copper",
    "duration": "end",
    "fe": "iron",
    "high": "fine",
    "hole": "thin",
    "impactor": "projectile",
    "incidence": "obliquity",
    "low": "draft",
    "medium": "standard",
    "mesh": "cells",
    "normal": "standard",
    "obliqueness": "obliquity",
    "pb": "lead",
    "resolution": "cells",
    "sphere": "projectile",
    "stainless": "steel",
    "timestep": "dt",
    "titanium": "ti",
    "v": "speed",
    "velocity": "speed",
    "w": "tungsten",
    "wolfram": "tungsten",
}


@dataclass(frozen=True)
class Renamed:
    """Names that people write for a feature's parameters; entry points ``whipple.studies.quantities.findings``."""

    name: str  # of the feature
    meant: Mapping[str, str]


MOST_LISTED = 5  # names in one cure
SPELLING, MISSPELT = 0.65, 0.88  # likeness of a name, and of a word with a meaning, that may be meant


def nearest_cure(value: object, allowed: Iterable[str]) -> str:
    """The cure for an unknown name: the nearest allowed ones, or some of them where none is near.

    >>> nearest_cure("thin_plat", ["thin_plate", "thick_plate"])
    "did you mean 'thin_plate'?"
    >>> nearest_cure("impact velocity", ["speed", "target"])
    "did you mean 'speed'?"
    >>> nearest_cure("alumnium", ["al-1100-o", "al-6061-t6", "lead"])
    "did you mean 'al-1100-o' or 'al-6061-t6'?"
    >>> nearest_cure("high", ["draft", "standard", "fine"])
    "did you mean 'fine'?"
    >>> nearest_cure("x", ["speed", "target"]), nearest_cure("x", "abcdefg")
    ('use one of: speed, target', 'use one of: a, b, c, d, e and 2 more')
    """
    names = sorted(allowed)
    if meant := _renamed(value, names):
        return f"write {meant}, not {value}"
    if close := nearest(value, names):
        first, last = ", ".join(map(repr, close[:-1])), repr(close[-1])
        return f"did you mean {first + ' or ' if first else ''}{last}?"
    more = f" and {len(names) - MOST_LISTED} more" if len(names) > MOST_LISTED else ""
    return "use one of: " + ", ".join(names[:MOST_LISTED]) + more if names else "leave it out"


def _renamed(value: object, names: Collection[str]) -> str | None:
    """The one of the names that is called differently; None of a value that is no other name for one."""
    renamed: Collection[Renamed] = entries(__name__, "RENAMED").values()
    meant = (feature.meant.get(value) for feature in renamed) if isinstance(value, str) else ()
    return next((name for name in meant if name in names), None)


def unknown_keys(mapping: Iterable[object], known: Collection[str], field: str, limit: str) -> Iterator[Finding]:
    """The error for each key of a mapping that is none of the known ones."""
    for key in mapping:
        if key not in known:
            yield Finding(f"{field}.{key}", shown(key), limit, nearest_cure(key, known))


def nearest(value: object, allowed: Iterable[str]) -> list[str]:
    """The names that an unknown name may be meant for; none where none is near.

    >>> nearest("velocity", ["speed", "target"]), nearest("x", ["speed", "target"])
    (['speed'], [])
    """
    if not isinstance(value, str) or len(value) > LONGEST_NAME:
        return []
    return _close(value, sorted(allowed))


def _close(written: str, names: list[str]) -> list[str]:
    """The names that are meant, if some are near: by words, else by spelling; of many, one that differs in case."""
    same = [name for name in names if name.lower() == written.lower()]
    if same or len(names) > MOST_NAMES:
        return same
    words = [_meant(word) for word in _words(written)]
    return (
        _sharing(words, names, least=len({*words}))
        or get_close_matches(written, names, n=1, cutoff=SPELLING)
        or _sharing(words, names)
    )


_WORDS = re.compile(r"[a-z]+|\d+")


def _words(name: str) -> list[str]:
    """The words and numbers of a name, each as names spell it."""
    return [SYNONYMS.get(word, word) for word in _WORDS.findall(name.lower())]


def _meant(word: str) -> str:
    """A word of a person, which may misspell one that has a meaning."""
    return next((SYNONYMS[near] for near in get_close_matches(word, SYNONYMS, n=1, cutoff=MISSPELT)), word)


def _sharing(words: list[str], names: list[str], least: int = 1) -> list[str]:
    """The names with most of these words and at least so many, those of the fewest others first."""
    shared = {name: len({*words} & {*_words(name)}) for name in names}
    most = max(shared.values(), default=0)
    best = [name for name, count in shared.items() if count == most >= max(1, least)]
    same = [name for name in best if _words(name) == words]
    return same or sorted(best, key=lambda name: (len(_words(name)), name))[:MOST_LISTED]


def shown(value: object) -> str:
    """A refused value as short text, whatever it is and however large.

    >>> shown("abc"), shown(6), shown(None)
    ("'abc'", '6', 'null')
    """
    if value is None:
        return "null"
    if isinstance(value, Mapping | list | tuple):
        return "a mapping" if isinstance(value, Mapping) else "a list"
    try:
        text = repr(value[: SHOWN_LENGTH + 1]) if isinstance(value, str) else str(value)
    except ValueError:  # an integer of thousands of digits
        text = f"<{type(value).__name__}>"
    return text if len(text) <= SHOWN_LENGTH else text[: SHOWN_LENGTH - 3] + "..."
