"""Decks of MPM3D as a stream of words and numbers, each with its line."""

import math
import re
from dataclasses import dataclass

from studies.scenarios._deck_macros import SHIFTS, Quantity
from studies.scenarios._deck_records import Vector, refuse_line

NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+))(?:[dDeE]([+-]?\d{1,4}))?")
INTEGER = re.compile(r"[+-]?\d{1,15}")
SEPARATORS = re.compile(r"[\s,]+")


@dataclass
class Word:
    """A word of a deck."""

    text: str
    line: int

    @property
    def key(self) -> str:
        """The four letters that name a macro."""
        return self.text.lower()[:4]


class Words:
    """The words of a deck, read one after another."""

    units: str

    def __init__(self, text: str):
        self.lines = text.splitlines()
        self.words = [
            Word(word, number)
            for number, line in enumerate(self.lines, 1)
            for word in SEPARATORS.split(_checked(line, number).partition("!")[0])
            if word
        ]
        self.at = 0

    def next(self, expected: str) -> Word:
        if self.at == len(self.words):
            last = max(len(self.lines), 1)
            cure = "the deck is cut off: complete it, and end it with endi"
            refuse_line(last, "the end of the text", expected, cure)
        self.at += 1
        return self.words[self.at - 1]

    def on_line(self, line: int) -> list[Word]:
        """Words that are left on a line."""
        end = self.at
        while end < len(self.words) and self.words[end].line == line:
            end += 1
        return self.words[self.at : end]

    def word(self, after: Word, expected: str) -> Word:
        if not self.on_line(after.line):
            cure = f"complete the line of {after.text!r}"
            refuse_line(after.line, "the end of the line", expected, cure)
        return self.next(expected)

    def number(self, after: Word, kind: Quantity, name: str = "") -> float:
        word = self.word(after, f"a number, {name or kind}")
        match = NUMBER.fullmatch(word.text)
        value = math.inf
        if match:
            power = int(match[2] or 0) + SHIFTS[self.units][kind]
            value = float(f"{match[1]}e{power}")
        if not math.isfinite(value):
            refuse_line(word.line, repr(word.text)[:60], f"a number, {name or kind}", "correct it")
        return value

    def numbers(self, after: Word, *kinds: Quantity) -> tuple[float, ...]:
        return tuple(self.number(after, kind) for kind in kinds)

    def vector(self, after: Word, kind: Quantity) -> Vector:
        return (self.number(after, kind), self.number(after, kind), self.number(after, kind))

    def integer(self, after: Word, name: str, low: int, high: int) -> int:
        word = self.word(after, f"a whole number, {name}")
        value = int(word.text) if INTEGER.fullmatch(word.text) else low - 1
        if not low <= value <= high:
            limit = f"{name}, a whole number from {low} to {high}"
            refuse_line(word.line, repr(word.text)[:60], limit, "correct it")
        return value


def _checked(line: str, number: int) -> str:
    for character in line:
        if ord(character) < 32 and character != "\t":
            what = f"control character {ord(character):#04x}"
            refuse_line(number, what, "printable text", "remove it")
    return line
