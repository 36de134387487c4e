"""Long texts of a cube, the decks of its runs, by name and digest where people read."""

import hashlib
from collections.abc import Mapping

import xarray as xr

from studies.cubes.variable import ROOT
from studies.quantities.parameters import Plain

LONGEST_NAME = 60  # characters of a first line
DIGITS = 16  # of the digest: two texts of one report do not share so many


def short_texts(dataset: xr.Dataset) -> dict[str, str]:
    """Each parameter's text of several lines in a cube, with the short form that stands for it."""
    texts = {
        str(text)
        for array in dataset.variables.values()
        if array.attrs["group"] in (ROOT, "inputs") and array.dtype.kind in "OUT"
        for text in array.values.ravel()
    }
    return {text: shortened(text) for text in sorted(texts) if "\n" in text}


def shortened(text: str) -> str:
    """The first line of a text that is not empty, how many lines there are, and the digest of all.

    >>> shortened("Bar of copper\\nppc 8\\n")
    'Bar of copper (2 lines, SHA-256 b8b6cfebda638c1d)'
    """
    lines = text.splitlines()
    name = next((line.strip() for line in lines if line.strip()), "")
    digest = hashlib.sha256(text.encode()).hexdigest()[:DIGITS]
    return f"{name[:LONGEST_NAME]} ({len(lines)} lines, SHA-256 {digest})"


def with_short_texts(plain: Plain, short: Mapping[str, str]) -> Plain:
    """Plain objects with the short forms, in keys, values and the middle of sentences."""
    if not short:
        return plain
    if isinstance(plain, str):
        for text, form in short.items():
            plain = plain.replace(text, form)
        return plain
    if isinstance(plain, Mapping):
        return {str(with_short_texts(k, short)): with_short_texts(v, short) for k, v in plain.items()}
    if isinstance(plain, list | tuple):
        return [with_short_texts(item, short) for item in plain]
    return plain
