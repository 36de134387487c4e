"""Numbers and lists in words: what every sentence about a sweep shares."""

from collections.abc import Sequence

from studies.quantities.display import NARROW_SPACE, decimals, display_of, printed_in

MOST_WORDS = 30  # of a headline
SAME = 5e-4  # a difference that rounds to 0.0 %
DOUBTS = {"second_hand": "second-hand", "unknown_alloy": "alloy unknown"}  # about a measured shot, by their codes
NONE_AT_ALL = "no difference"


def share(size: float) -> str:
    """A share in per cent: "6 %", "0.4 %".

    >>> share(0.0601), share(0.004)
    ('6\u202f%', '0.4\u202f%')
    """
    return f"{_whole(size)}{NARROW_SPACE}%"


def difference(residuals: Sequence[float]) -> str:
    """Relative differences in words, without a side that rounds to nothing.

    >>> difference([-0.25, -0.16]), difference([-0.03, 0.04]), difference([-0.0003, 0.009])
    ('16 to 25\u202f% low', '3\u202f% low to 4\u202f% high', '0 to 0.9\u202f% high')
    """
    low, high = min(residuals), max(residuals)
    if max(-low, high) < SAME:
        return NONE_AT_ALL
    if min(-low, high) >= SAME:
        return f"{share(-low)} low to {share(high)} high"
    ends = dict.fromkeys(map(_whole, sorted((abs(low), abs(high)))))
    return f"{' to '.join(ends)}{NARROW_SPACE}% {'low' if -low > high else 'high'}"


def _whole(share: float) -> str:
    return decimals(100.0 * share, 0 if abs(share) >= 0.01 else 1).removesuffix(".0")


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


def shortest(texts: Sequence[str]) -> str:
    """The first text with at most ``MOST_WORDS`` words; where none has so few, the beginning of the last one."""
    short = (text for text in texts if len(text.split()) <= MOST_WORDS)
    return next(short, f"{' '.join(texts[-1].split()[:MOST_WORDS])}…")


def spanned(low: str, high: str) -> str:
    """Two printed numbers as a range: "2-7", and one where they are the same.

    >>> spanned("2", "7"), spanned("6", "6"), spanned("−1", "2")
    ('2-7', '6', '−1 to 2')
    """
    if low == high:
        return low
    return f"{low} to {high}" if "−" in low + high else f"{low}-{high}"
