"""What tells sweeps apart: the parts of their documents in words, and those in which they differ."""

import json
from collections.abc import Iterator, Mapping, Sequence

from studies.quantities.parameters import Plain

NAMED = ("title", "name", "scenario")  # keys of a document that name it and ask for nothing
LONGEST = 60  # characters of a part in words
FEW = 3  # parts that tell sweeps of one title apart
NONE = "–"


def in_words(values: Plain) -> str:
    """The values of an axis, or another part of a document.

    >>> in_words(["2 mm", "4 mm"]), in_words(["2 km/s", "3 km/s", "7 km/s"]), in_words({"limit_of": "perforated"})
    ('2 mm, 4 mm', '2 km/s to 7 km/s (3 values)', '{"limit_of": "perforated"}')
    """
    if isinstance(values, list | tuple) and len(values) > 2 and not isinstance(values[0], dict | list):
        return f"{in_words(values[0])} to {in_words(values[-1])} ({len(values)} values)"
    if isinstance(values, list | tuple):
        return ", ".join(map(in_words, values))
    text = f"{values:g}" if isinstance(values, float) else values
    text = text if isinstance(text, str) else json.dumps(text, ensure_ascii=False)
    return text if len(text) <= LONGEST else f"{text[:LONGEST]}…"


def parts_of(document: Mapping[str, Plain]) -> dict[str, str]:
    """The parts of a canonical document in words, by what they are about."""
    parts: dict[str, str] = {}
    for key, value in document.items():
        inside = value if key in ("fixed", "axes") and isinstance(value, Mapping) else {key: value}
        parts |= {name.replace("_", " "): in_words(each) for name, each in inside.items() if name not in NAMED}
    return parts


def differences(documents: Sequence[Mapping[str, Plain]]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The parts in which documents differ: what each is about, and the words of each document."""
    every = [parts_of(document) for document in documents]
    for name in dict.fromkeys(name for parts in every for name in parts):
        texts = tuple(parts.get(name, NONE) for parts in every)
        if len({*texts}) > 1:
            yield name, texts


def told_apart(documents: Mapping[str, Mapping[str, Plain]]) -> dict[str, str]:
    """By id, in what each of some sweeps of one title differs from the others; empty of the same request."""
    found = list(differences([*documents.values()]))
    return {
        id: ", ".join(f"{name} {texts[place]}" for name, texts in found[:FEW]) for place, id in enumerate(documents)
    }
