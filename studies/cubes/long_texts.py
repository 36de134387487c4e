"""Long texts of a cube, the decks of its runs, by name and digest where people read."""

import hashlib
import json
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
    text = json.dumps(plain)
    for long, form in short.items():
        text = text.replace(json.dumps(long)[1:-1], json.dumps(form)[1:-1])
    whole: Plain = json.loads(text)
    return whole
