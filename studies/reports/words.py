"""Numbers and lists in words: what every sentence about a sweep shares."""

from collections.abc import Sequence

from studies.quantities.display import MINUS, NARROW_SPACE, decimals, display_of, printed_in

MOST_WORDS = 30  # of a headline


def share(size: float) -> str:
    """A share in per cent: "6 %", "0.4 %".

    >>> share(0.0601), share(0.004)
    ('6\u202f%', '0.4\u202f%')
    """
    return f"{decimals(100.0 * size, 0 if size >= 0.01 else 1).removesuffix('.0')}{NARROW_SPACE}%"


def signed(low: float, high: float) -> str:
    """Differences with their signs.

    >>> signed(-0.07, 0.04), signed(-0.1, -0.1), signed(-0.0003, 0.009)
    ('−7 to +4\u202f%', '−10\u202f%', '0 to +0.9\u202f%')
    """
    ends = ((end, share(abs(end))) for end in (low, high))
    told = [text if text == share(0.0) else f"{'+' if end > 0.0 else MINUS}{text}" for end, text in ends]
    return told[0] if told[0] == told[1] else f"{told[0].removesuffix(f'{NARROW_SPACE}%')} to {told[1]}"


def number_of(value: float | str, unit: str | None) -> str:
    return value if isinstance(value, str) else printed_in(value, unit)


def unit_of(unit: str | None) -> str:
    name = display_of(unit).unit
    return f" {name}" if name else ""


def words(name: str) -> str:
    return name.replace("_", " ")


def capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def joined(parts: Sequence[str], last: str = "and") -> str:
    """ "a", "a and b", "a, b and c"."""
    return f" {last} ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))


def spanned(low: str, high: str) -> str:
    """Two printed numbers as a range: "2-7", and one where they are the same.

    >>> spanned("2", "7"), spanned("6", "6"), spanned("−1", "2")
    ('2-7', '6', '−1 to 2')
    """
    if low == high:
        return low
    return f"{low} to {high}" if "−" in low + high else f"{low}-{high}"
