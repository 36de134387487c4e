"""Texts of the files that people bring: bytes in the encodings that editors and spreadsheets write."""

import codecs
from typing import NoReturn

from studies.quantities.findings import Finding, InvalidInput

# Byte order marks, the longest first: that of UTF-32 begins with that of UTF-16.
MARKS: tuple[tuple[bytes, str], ...] = (
    (codecs.BOM_UTF32_LE, "UTF-32"),
    (codecs.BOM_UTF32_BE, "UTF-32"),
    (codecs.BOM_UTF8, "UTF-8"),
    (codecs.BOM_UTF16_LE, "UTF-16"),
    (codecs.BOM_UTF16_BE, "UTF-16"),
)
WESTERN = "cp1252"  # of Windows in western Europe and America; holds all of Latin-1 that is printable


def decoded(content: bytes, field: str) -> str:
    """The text of a file in UTF-8, in UTF-16 or UTF-32 with their marks, in plain UTF-16, or in Windows-1252 (Latin-1).

    What is no UTF-8 and has no NUL is read as Windows-1252, whose plus-minus, micro and degree signs, superscripts and
    dashes are those of most of its relatives. Raises InvalidInput naming the encoding and the line.
    """
    encoding = next((name for mark, name in MARKS if content.startswith(mark)), "") or _without_mark(content)
    if encoding == "UTF-8" and b"\0" in content:
        _refuse(content, content.index(b"\0"), field, "text, which has no NUL")
    try:
        return content.decode("utf-8-sig" if encoding == "UTF-8" else encoding)
    except UnicodeDecodeError as error:
        if encoding != "UTF-8" or content.startswith(codecs.BOM_UTF8):
            _refuse(content, error.start, field, f"text in {encoding}, as it begins")
    try:
        return content.decode(WESTERN)
    except UnicodeDecodeError as error:
        _refuse(content, error.start, field, "text in UTF-8, or in Windows-1252 (Latin-1)")


def strictly_decoded(content: bytes, field: str) -> str:
    """The text of bytes in UTF-8, with or without its mark; raises InvalidInput naming the encoding that they have."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        mark = next((name for mark, name in MARKS if content.startswith(mark)), "")
        seems = mark or ("Windows-1252 (Latin-1)" if b"\0" not in content else "UTF-16 without its mark")
        _refuse(content, error.start, field, f"text in UTF-8; this seems to be {seems}")


def _without_mark(content: bytes) -> str:
    """UTF-16 where every NUL is the same half of a character, as in a text in Latin letters; else UTF-8."""
    if b"\0" in content[:2]:
        halves = content[0::2], content[1::2]
        for own, other, encoding in ((halves[0], halves[1], "UTF-16-LE"), (halves[1], halves[0], "UTF-16-BE")):
            if len(content) % 2 == 0 and b"\0" not in own and other.count(0) * 2 > len(other):
                return encoding
    return "UTF-8"


def _refuse(content: bytes, place: int, field: str, limit: str) -> NoReturn:
    line = content.count(b"\n", 0, place) + 1
    byte = f"byte {content[place]:#04x} in line {line}"
    raise InvalidInput([Finding(field, byte, limit, "save it as UTF-8")]) from None
