"""The nearest allowed name, for the cure of a finding."""

from collections.abc import Iterable, Mapping
from difflib import get_close_matches

SHOWN_LENGTH = 60  # characters of a refused value that a person still recognises
LONGEST_NAME = 100  # characters of a text that may be meant for a name
MOST_NAMES = 200  # that are compared with it, and listed: one takes up to 30 us (2026-11)


def nearest_cure(value: object, allowed: Iterable[str]) -> str:
    """The cure for an unknown name: the nearest allowed one, or all of them where none is near.

    >>> nearest_cure("thin_plat", ["thin_plate", "thick_plate"])
    "did you mean 'thin_plate'?"
    >>> nearest_cure("x", ["speed", "target"])
    'use one of: speed, target'
    """
    names = sorted(allowed)
    written = value if isinstance(value, str) else ""
    close = _close(written, names) if len(written) <= LONGEST_NAME else []
    if close:
        return f"did you mean {close[0]!r}?"
    more = f" and {len(names) - MOST_NAMES} more" if len(names) > MOST_NAMES else ""
    return "use one of: " + ", ".join(names[:MOST_NAMES]) + more if names else "leave it out"


def _close(written: str, names: list[str]) -> list[str]:
    """The name that is meant, if one is near; of many only one that differs in case."""
    same = [name for name in names if name.lower() == written.lower()]
    if same or len(names) > MOST_NAMES:
        return same
    return get_close_matches(written, names, n=1, cutoff=0.6)


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
