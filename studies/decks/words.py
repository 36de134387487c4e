"""Decks of MPM3D as a stream of words and numbers, each with its line."""

import math
import re
from collections.abc import Iterable
from dataclasses import dataclass
from typing import NoReturn

from studies.decks.deck import Units, Vector, refuse_line
from studies.decks.macros import SHIFTS, DeckQuantity
from studies.quantities.findings import nearest_cure

NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[dDeE]([+-]?\d{1,4}))?")
INTEGER = re.compile(r"[+-]?\d{1,15}")
SEPARATORS = re.compile(r"[\s,]+")
CONTROL = re.compile(r"[\x00-\x08\x0a-\x1f]")


@dataclass
class DeckWord:
    """A word of a deck."""

    text: str
    line: int

    @property
    def key(self) -> str:
        """The four letters that name a macro."""
        return self.text.lower()[:4]

    def refuse(self, limit: str, cure: str, value: str = "") -> NoReturn:
        """Raise the error of the line with this word, or with what it stands for."""
        refuse_line(self.line, value or repr(self.text)[:60], limit, cure)


class Words:
    """The words of a deck, read one after another."""

    units: Units

    def __init__(self, text: str):
        self.lines = text.splitlines()
        self.words: list[DeckWord] = []
        self.at = 0
        for number, line in enumerate(self.lines, 1):
            if control := CONTROL.search(line):
                refuse_line(number, f"control character {ord(control[0]):#04x}", "printable text", "remove it")
            self.words += [DeckWord(word, number) for word in SEPARATORS.split(line.partition("!")[0]) if word]

    def next(self, expected: str) -> DeckWord:
        """The next word of the deck."""
        word = self.peek(expected)
        self.at += 1
        return word

    def peek(self, expected: str) -> DeckWord:
        """The next word of the deck, which is read again."""
        if self.at == len(self.words):
            cure = "the deck is cut off: complete it, and end it with endi"
            refuse_line(max(len(self.lines), 1), "the end of the text", expected, cure)
        return self.words[self.at]

    def on_line(self, line: int) -> list[DeckWord]:
        """Words that are left on a line."""
        end = self.at
        while end < len(self.words) and self.words[end].line == line:
            end += 1
        return self.words[self.at : end]

    def word(self, after: DeckWord, expected: str) -> DeckWord:
        """The next word of a line."""
        if self.at == len(self.words) or self.words[self.at].line != after.line:
            after.refuse(expected, f"complete the line of {after.text!r}", "the end of the line")
        return self.next(expected)

    def chosen(self, word: DeckWord, limit: str, choices: Iterable[str], cure: str = "") -> DeckWord:
        """A word whose four letters are one of some."""
        if word.key not in choices:
            word.refuse(limit, cure or nearest_cure(word.key, choices), repr(word.text))
        return word

    def number(self, after: DeckWord, kind: DeckQuantity, name: str = "") -> float:
        """The next number of a line, in SI."""
        word = self.word(after, f"a number, {name or kind}")
        match = NUMBER.fullmatch(word.text)
        value = math.inf
        if match:
            power = int(match[2] or 0) + SHIFTS[self.units].get(kind, 0)
            value = float(f"{match[1]}e{power}")
        if not math.isfinite(value):
            word.refuse(f"a number, {name or kind}", "correct it")
        return value

    def numbers(self, after: DeckWord, *kinds: DeckQuantity) -> tuple[float, ...]:
        """The next numbers of a line."""
        return tuple(self.number(after, kind) for kind in kinds)

    def vector(self, after: DeckWord, kind: DeckQuantity) -> Vector:
        """Three numbers of a line."""
        return (self.number(after, kind), self.number(after, kind), self.number(after, kind))

    def integer(self, after: DeckWord, name: str, low: int, high: int) -> int:
        """The next whole number of a line."""
        word = self.word(after, f"a whole number, {name}")
        value = int(word.text) if INTEGER.fullmatch(word.text) else low - 1
        if not low <= value <= high:
            word.refuse(f"{name}, a whole number from {low} to {high}", "correct it")
        return value
