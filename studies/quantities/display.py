"""Printed numbers: files and programs have SI, and people display units, by one function for each kind of number."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass

from studies.quantities.units import DISPLAY_UNITS

NONE = "–"
NARROW_SPACE = "\u202f"
# A balance is a sum of up to a billion terms, each exact to 1e-16: what is smaller is no error of a program.
ROUND_OFF = 1e-9
MINUS = "\u2212"
MESH_UNKNOWN = "mesh error unknown"  # in place of the error bar of a value of a single grid
MOST_PLACES = 6  # decimals of a value beside its error bar
SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

# Characters that command a terminal, or turn the direction of a text around; not tab and ends of lines.
CONTROLS = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")


def escaped(text: str) -> str:
    """A text of another user for a terminal, with its control characters as JSON writes them.

    >>> print(escaped("fine\\n\\x1b[2J"))
    fine
    \\u001b[2J
    """
    shown = CONTROLS.sub(lambda match: f"\\u{ord(match[0]):04x}", text)
    return shown.replace("\r", "\\r")


@dataclass(frozen=True)
class Display:
    """The unit in which a column of a table or an axis of a figure is read."""

    factor: float  # from SI
    unit: str


def display_of(unit: str | None) -> Display:
    """The display unit of an SI unit; the SI unit itself where none is listed, nothing of a plain number.

    >>> display_of("m"), display_of("s").unit, display_of("1").unit
    (Display(factor=1000.0, unit='mm'), 'µs', '')
    """
    if unit is None or unit == "1":
        return Display(1.0, "")
    for display in DISPLAY_UNITS.get(unit, ()):
        if display.of_columns:
            return Display(1.0 / display.size, _raised(re.sub("^u", "µ", display.name)))
    return Display(1.0, _raised(unit))


def display_alone(value: float | bool | str | None, unit: str | None) -> Display:
    """The display unit of a number that stands alone: the largest in which it is no small fraction.

    >>> display_alone(1.3e11, "Pa").unit, display_alone(9e7, "Pa").unit, display_alone(8930.0, "kg m-3").unit
    ('GPa', 'MPa', 'kg m⁻³')
    """
    if isinstance(value, float | int) and not isinstance(value, bool) and value:
        for display in DISPLAY_UNITS.get(unit or "1", ()):
            if abs(value) >= display.smallest:
                return Display(1.0 / display.size, _raised(re.sub("^u", "µ", display.name)))
    return display_of(unit)


def _raised(unit: str) -> str:
    """A UDUNITS symbol as people write it.

    >>> _raised("J kg-1 K-1"), _raised("Pa m0.5")
    ('J kg⁻¹ K⁻¹', 'Pa √m')
    """
    unit = re.sub(r"\b([A-Za-z]+)0\.5\b", r"√\1", unit)
    return re.sub(r"(?<=[A-Za-z])-?\d+", lambda power: power[0].translate(SUPERSCRIPTS), unit)


def with_unit(label: str, unit: str | None) -> str:
    """A heading: "speed (km/s)"."""
    name = display_of(unit).unit
    return f"{label} ({name})" if name else label


def decimals(value: float, places: int) -> str:
    """A number with fixed decimals and a proper minus.

    >>> decimals(-1.256, 2)
    '−1.26'
    """
    text = f"{value:.{places}f}"
    return (text.removeprefix("-") if float(text) == 0 else text).replace("-", MINUS)


def signed(value: float, places: int) -> str:
    """A number that shows its sign: residuals.

    >>> signed(0.123, 1)
    '+0.1'
    """
    text = decimals(value, places)
    return text if text.startswith(MINUS) or float(text) == 0 else f"+{text}"


def digits(value: float, significant: int = 3) -> str:
    """A number with significant digits; powers of ten where it is very small or large.

    >>> digits(0.01234), digits(3.1e-14), digits(182345.0), digits(769500.5), digits(0.0), digits(12.0)
    ('0.0123', '3.1·10⁻¹⁴', '182\u202f345', '770\u202f000', '0', '12')
    """
    if value == 0:
        return "0"
    if value == int(value) and abs(value) < 1e7:
        return f"{int(value):,}".replace(",", NARROW_SPACE).replace("-", MINUS)
    if 1e4 <= abs(value) < 1e7:
        return digits(float(f"{value:.{significant}g}"))
    if 1e-3 <= abs(value) < 1e4:
        return f"{float(f'{value:.{significant}g}'):.12g}".replace("-", MINUS)
    mantissa, exponent = f"{value:.{significant - 1}e}".split("e")
    power = str(int(exponent)).translate(SUPERSCRIPTS)
    return f"{float(mantissa):g}·10{power}".replace("-", MINUS)


def percent(chance: float) -> str:
    """A chance in per cent, which is never none and never certain.

    >>> percent(0.004), percent(0.456), percent(0.996)
    ('<1', '46', '>99')
    """
    hundredths = 100.0 * chance
    return "<1" if hundredths < 0.5 else ">99" if hundredths >= 99.5 else f"{hundredths:.0f}"


def is_round_off(value: float | None) -> bool:
    """Whether a share is no more than what sums of floating-point numbers leave."""
    return value is not None and 0.0 < abs(value) < ROUND_OFF


def of_share(value: float) -> str:
    """A fraction in per cent, three significant digits; a word where it is round-off.

    >>> of_share(0.0123), of_share(-3e-15), of_share(0.0)
    ('1.23\u202f%', 'round-off', '0\u202f%')
    """
    if is_round_off(value):
        return "round-off"
    return f"{digits(value * 100)}{NARROW_SPACE}%"


def _millimetres(value: float) -> float:
    return value * display_of("m").factor


def _ratio(value: float) -> str:
    """Three decimals; two digits of what would vanish by them, such as the uncertainty of a small ratio."""
    return digits(value, 2) if 0.0 < abs(value) < 1e-3 else decimals(value, 3)


RESIDUAL = "_residual"  # end of the kinds whose numbers show their sign

# Kinds of numbers that a report prints, by the word that a template uses.
KINDS: dict[str, Callable[[float], str]] = {
    "count": digits,
    "length": lambda value: decimals(_millimetres(value), 2),
    "length_residual": lambda value: signed(_millimetres(value), 2),
    "ratio": _ratio,
    "ratio_residual": lambda value: signed(value, 3),
    "share": of_share,
    "share_residual": lambda value: f"{signed(value * 100, 1)}{NARROW_SPACE}%",
    "size": lambda value: f"{decimals(abs(value) * 100, 1)}{NARROW_SPACE}%",
    "share_spread": lambda value: f"{decimals(value * 100, 1)}{NARROW_SPACE}%",
    "order": lambda value: decimals(value, 2),
    "seconds": lambda value: decimals(value, 1),
    "plain": digits,
}


def kind_of(unit: str, *, residual: bool = False) -> str:
    """The kind of number for a measured quantity of a unit; the unit itself where it has no kind of its own."""
    kind = {"m": "length", "1": "ratio"}.get(unit, unit)
    return f"{kind}{RESIDUAL}" if residual else kind


def printed(value: float | None, kind: str) -> str:
    """A number as a report prints it; a dash where there is none.

    >>> printed(459e-9, "m3"), printed(5310.0, "m s-1"), printed(-2e-6, "s_residual"), printed(0.0123, "length")
    ('459', '5.31', '−2', '12.30')
    """
    if value is None or not math.isfinite(value):
        return NONE
    if kind in KINDS:
        return KINDS[kind](value)
    text = printed_in(value, kind.removesuffix(RESIDUAL))
    return f"+{text}" if kind.endswith(RESIDUAL) and value > 0.0 else text


def printed_beside(value: float | None, kind: str, bar: float | None) -> str:
    """A value or its error bar as a report prints them side by side: both to the second digit of the bar.

    Lengths have their fixed decimals; so has everything without a bar.

    >>> printed_beside(4590e-9, "m3", 980.5e-9), printed_beside(980.5e-9, "m3", 980.5e-9)
    ('4\u202f590', '980')
    >>> printed_beside(0.0071, "ratio", 1.6e-4), printed_beside(5312.0, "m s-1", 123.0)
    ('0.00710', '5.31')
    """
    if kind in KINDS and kind != "ratio":
        return printed(value, kind)
    if value is None or not math.isfinite(value) or not bar or not math.isfinite(bar):
        return printed(value, kind)
    factor = 1.0 if kind == "ratio" else display_of(kind).factor
    places = 1 - math.floor(math.log10(float(f"{abs(bar * factor):.1e}")))
    if places > MOST_PLACES:
        return printed(value, kind)
    number = round(value * factor, places)
    return f"{number:,.{max(0, places)}f}".replace(",", NARROW_SPACE).replace("-", MINUS)


def with_bar(value: str, bar: str | None) -> str:
    """A printed value with its error bar; of a single grid, which has none, with the words that say so.

    >>> with_bar("23.43 mm", "0.22 mm"), with_bar("172.5 m/s", None)
    ('23.43 mm ± 0.22 mm', '172.5 m/s (mesh error unknown)')
    """
    return f"{value} ± {bar}" if bar else f"{value} ({MESH_UNKNOWN})"


def printed_in(value: float | bool | None, unit: str | None) -> str:
    """A number of any SI unit in its display unit, with four significant digits."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value is None or not math.isfinite(value):
        return NONE
    return digits(float(f"{value * display_of(unit).factor:.12g}"), 4)


def printed_alone(value: float | bool | None, unit: str | None) -> str:
    """A number that stands alone, in the unit of its size, with four significant digits."""
    if value is None or isinstance(value, bool) or not math.isfinite(value):
        return printed_in(value, unit)
    return digits(float(f"{value * display_alone(value, unit).factor:.12g}"), 4)


def elapsed(seconds: float) -> str:
    """A time of a run with three digits and its unit.

    >>> elapsed(1.2345e-5)
    '12.3 µs'
    """
    return f"{printed_in(float(f'{seconds:.3g}'), 's')} {display_of('s').unit}"


def duration(seconds: float | None) -> str:
    """A time span for people.

    >>> duration(42.0), duration(90.0), duration(3720.0), duration(None)
    ('42 s', '1 min 30 s', '1 h 02 min', '')
    """
    if seconds is None:
        return ""
    minutes, rest = divmod(round(seconds), 60)
    if minutes == 0:
        return f"{rest} s"
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"
