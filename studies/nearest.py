"""The nearest allowed name, for the cure of a finding."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches

SHOWN_LENGTH = 60  # characters of a refused value that a person still recognises


def nearest_cure(given: object, allowed: Iterable[str]) -> str:
    """The cure for an unknown name: the nearest allowed one, or all of them where none is near.

    >>> nearest_cure("thin_plat", ["thin_plate", "thick_plate"])
    "did you mean 'thin_plate'?"
    >>> nearest_cure("x", ["speed", "target"])
    'use one of: speed, target'
    """
    names = sorted(allowed)
    close = [name for name in names if name.lower() == str(given).lower()]
    close = close or get_close_matches(str(given), names, n=1, cutoff=0.6)
    if close:
        return f"did you mean {close[0]!r}?"
    return "use one of: " + ", ".join(names) if names else "leave it out"


def shown(given: object) -> str:
    """A refused value as short text, whatever it is and however large.

    >>> shown("abc"), shown(6), shown(None)
    ("'abc'", '6', 'null')
    """
    if given is None:
        return "null"
    if isinstance(given, Mapping | list | tuple):
        return "a mapping" if isinstance(given, Mapping) else "a list"
    try:
        text = repr(given) if isinstance(given, str) else str(given)
    except ValueError:  # an integer of thousands of digits
        text = f"<{type(given).__name__}>"
    return text if len(text) <= SHOWN_LENGTH else text[: SHOWN_LENGTH - 3] + "..."
