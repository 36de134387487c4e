"""Units of user input: "6 km/s" becomes an exact SI number, or an error with its cure.

Only here does a unit other than SI exist, and only here is pint imported, at the first value in no usual unit. Numbers
stay exact decimals until ``round_quantity`` makes the float: "2.4 mm" and "0.0024 m" are the same run.
"""

import math
import re
from dataclasses import dataclass
from decimal import Decimal, DecimalException
from functools import cache, lru_cache
from numbers import Rational, Real
from typing import TYPE_CHECKING, TypeGuard

from studies.quantities.findings import refusal

if TYPE_CHECKING:
    from pint import UnitRegistry

# More than any input is known to, fewer than a float holds: a stable identity.
SIGNIFICANT_DIGITS = 12
# Decimal exponent beyond which no quantity of this field lies; keeps floats finite.
LARGEST_EXPONENT = 200
LONGEST_TEXT = 80  # characters; a longer "number" is a mistake or an attack

# One number (underscores, commas, expressions are refused), then a unit.
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,4})?"
_UNIT = '(?:1?/|[A-Za-z°µμΩ("″])'  # the beginning of one
_QUANTITY = re.compile(rf"\s*({_NUMBER})\s*({_UNIT}.*)?\s*", re.DOTALL)
# A fraction of an inch: 1/8 in, 1 1/8".
_OF_AN_INCH = re.compile(r'\s*(?:(\d{1,4}) )?(\d{1,4})/([1-9]\d{0,3})\s*(in|inch|inches|["″])\s*')
# Factors of the units that materials and most sweeps are written in: pint is loaded (0.3 s of processor time,
# 2026-11-22) for the others only. The test compares each with pint.
_FACTORS = {
    ("mm", "m"): Decimal("1e-3"),
    ("cm", "m"): Decimal("1e-2"),
    ("in", "m"): Decimal("0.0254"),
    ('"', "m"): Decimal("0.0254"),
    ("″", "m"): Decimal("0.0254"),
    ("mil", "m"): Decimal("2.54e-5"),  # a thousandth of an inch; of an angle it is pint's
    ("mils", "m"): Decimal("2.54e-5"),
    ("deg", "rad"): Decimal("0.01745329251994329576923690768"),
    ("ksi", "Pa"): Decimal("6894757.293168361336722673443"),
    ("us", "s"): Decimal("1e-6"),
    ("km/s", "m s-1"): Decimal("1e3"),
    ("m/s", "m s-1"): Decimal(1),
    ("1/s", "s-1"): Decimal(1),
    ("K", "K"): Decimal(1),
    ("1/K", "K-1"): Decimal(1),
    ("MPa", "Pa"): Decimal("1e6"),
    ("GPa", "Pa"): Decimal("1e9"),
    ("1/TPa", "Pa-1"): Decimal("1e-12"),
    ("kg/m3", "kg m-3"): Decimal(1),
    ("g/cm3", "kg m-3"): Decimal("1e3"),
    ("g/ccm", "kg m-3"): Decimal("1e3"),
    ("MJ/kg", "J kg-1"): Decimal("1e6"),
    ("kJ/kg", "J kg-1"): Decimal("1e3"),
    ("J/(kg K)", "J kg-1 K-1"): Decimal(1),
    ("MPa m0.5", "Pa m0.5"): Decimal("1e6"),
    ("N/m", "N m-1"): Decimal(1),
}
_WORD = re.compile(r"([A-Za-z°µμΩ]++)(?:(?:\*\*|\^)?([+-]?\d(?:\.5)?))?")  # one run of letters, never two
_SUPERSCRIPTS = str.maketrans({"²": "2", "³": "3", "⁻": "-", "¹": "1", "−": "-", "·": "*", "⋅": "*"})

# Name of the dimension of each SI unit, and the units in which people usually write it.
_DIMENSIONS: dict[str, tuple[str, tuple[str, ...]]] = {
    "m": ("length", ("mm", "m")),
    "m3": ("volume", ("mm3", "cm3")),
    "s": ("time", ("us", "s")),
    "kg": ("mass", ("g", "kg")),
    "K": ("temperature", ("K", "degC")),
    "Pa": ("pressure or stress", ("MPa", "GPa")),
    "Pa-1": ("rate of change with pressure", ("1/TPa", "1/Pa")),
    "K-1": ("rate of change with temperature", ("1/K",)),
    "Pa m0.5": ("fracture toughness", ("MPa m0.5",)),
    "N m-1": ("surface tension", ("N/m",)),
    "J": ("energy", ("J", "kJ")),
    "N s": ("momentum", ("N s",)),
    "s-1": ("rate", ("1/s",)),
    "m s-1": ("speed", ("km/s", "m/s")),
    "m s-2": ("acceleration", ("m/s2",)),
    "kg m-3": ("density", ("g/cm3", "kg/m3")),
    "J kg-1": ("specific energy", ("kJ/kg", "J/kg")),
    "J kg-1 K-1": ("heat capacity", ("J/(kg K)",)),
    "rad": ("angle", ("deg", "rad")),
    "degree": ("angle", ("deg", "rad")),
}


@dataclass(frozen=True)
class DisplayUnit:
    """A unit in which people read sizes of one SI unit."""

    name: str  # as parse_quantity reads it
    size: float  # size of one unit, in SI
    smallest: float  # SI size from which on a value that stands alone is written in it
    of_columns: bool = False  # the one unit of a table's column and of a figure's axis


# For each SI unit, the largest first.
DISPLAY_UNITS: dict[str, tuple[DisplayUnit, ...]] = {
    "m": (DisplayUnit("m", 1.0, 1.0), DisplayUnit("mm", 1e-3, 1e-4, of_columns=True), DisplayUnit("um", 1e-6, 0.0)),
    "m3": (DisplayUnit("m3", 1.0, 1.0), DisplayUnit("mm3", 1e-9, 0.0, of_columns=True)),
    "s": (
        DisplayUnit("s", 1.0, 1.0),
        DisplayUnit("ms", 1e-3, 1e-3),
        DisplayUnit("us", 1e-6, 1e-7, of_columns=True),
        DisplayUnit("ns", 1e-9, 0.0),
    ),
    "Pa": (DisplayUnit("GPa", 1e9, 1e9, of_columns=True), DisplayUnit("MPa", 1e6, 1e5), DisplayUnit("Pa", 1.0, 0.0)),
    "m s-1": (DisplayUnit("km/s", 1e3, 1e3, of_columns=True), DisplayUnit("m/s", 1.0, 0.0)),
    "rad": (DisplayUnit("deg", math.pi / 180.0, 0.0, of_columns=True),),
}
DEGREES_DIGITS = 10  # two fewer than are kept: 75 deg is 1.30899693900 rad, or 75.0000000002 deg
PI = Decimal("3.141592653589793238462643383279")  # more digits than the context of decimals keeps


def round_quantity(value: float | Decimal) -> float:
    """A quantity at 12 significant digits: what is used, hashed and stored; zero has no sign.

    >>> round_quantity(0.1 + 0.2)
    0.3
    """
    return float(format(value, f".{SIGNIFICANT_DIGITS}g")) + 0.0


def readable(value: float, unit: str) -> str:
    """An SI value as a person writes it, and as ``parse_quantity`` reads it.

    >>> readable(6000.0, "m s-1"), readable(0.002, "m"), readable(0.0, "m"), readable(0.5, "1")
    ('6 km/s', '2 mm', '0 mm', '0.5')
    >>> readable(1.308996939, "rad"), readable(1.3, "rad")
    ('75 deg', '1.3 rad')
    """
    if unit == "1":
        return f"{value:.12g}"
    if unit == "rad":
        return _degrees(value) or f"{value:.12g} rad"
    for display in DISPLAY_UNITS.get(unit, ()):
        if abs(value) >= display.smallest or (value == 0.0 and display.of_columns):
            return f"{round_quantity(value / display.size):.12g} {display.name}"
    return f"{value:.12g} {unit}"


@dataclass(frozen=True)
class Bounds:
    """The allowed values of a quantity, in SI; None where there is no bound."""

    minimum: float | None = None
    maximum: float | None = None

    def nearest(self, value: float) -> float:
        """The allowed number that is nearest to a value."""
        if self.minimum is not None and value < self.minimum:
            return self.minimum
        if self.maximum is not None and value > self.maximum:
            return self.maximum
        return value


UNBOUNDED = Bounds()


def parse_quantity(raw: object, unit: str, field: str, bounds: Bounds = UNBOUNDED) -> Decimal:
    """A quantity given as text with its unit, as an exact number of the SI ``unit``.

    Raises InvalidInput: not a text, no unit, unknown unit, another dimension, not finite. Every value that its
    cure proposes lies inside ``bounds``, which are not checked here.

    >>> parse_quantity("6.1 km/s", "m s-1", "speed"), parse_quantity('1/8"', "m", "length")
    (Decimal('6100'), Decimal('0.0031750'))
    """
    if unit == "1":
        return exact_number(raw, field)
    if is_number(raw):
        digits, unit_text = _digits(raw), ""
    else:
        digits, unit_text = _split(raw, unit, field, bounds)
    number = _decimal(digits, raw, field, _cure(unit, bounds))
    if not unit_text:
        raise refusal(field, raw, _allowed(unit), _cure_for_bare_number(number, unit, bounds))
    return convert(number, unit_text, unit, field, bounds)


def pattern_of(unit: str) -> str:
    """A regular expression (ECMA 262) for every text that ``parse_quantity`` reads in an SI unit.

    It lets units through that pint knows and no list here; refused are numbers without a unit, and with a listed one of
    another dimension.

    >>> [bool(re.search(pattern_of("m"), text)) for text in ("2 mm", '1/8"', "3 furlongs", "2", "2 km/s", "1e-3")]
    [True, True, True, False, False, False]
    """
    if unit == "1":
        return rf"^\s*{_NUMBER}\s*$"
    usual = {(name, of) for of, (_, names) in _DIMENSIONS.items() for name in names} | {*_FACTORS}
    own = {text for text, of in usual if of == unit} | ({"mil", "mils"} if unit in ("rad", "degree") else set())
    others = "|".join(re.sub("[().]", r"\\\g<0>", text) for text in sorted({text for text, _ in usual} - own))
    quantity = rf"{_NUMBER}\s*(?!(?:{others})\s*$|[eE][+-]?\d){_UNIT}[\s\S]*"
    inches = rf"|{_OF_AN_INCH.pattern}" if unit == "m" else ""
    return rf"^\s*(?:{quantity}{inches})$"


def convert(number: Decimal, unit_text: str, unit: str, field: str, bounds: Bounds = UNBOUNDED) -> Decimal:
    """A number in any unit, as an exact number of the SI ``unit``; raises InvalidInput."""
    raw, cure = f"{number} {unit_text}", _cure(unit, bounds)
    conversion = None
    if len(unit_text) <= LONGEST_TEXT:
        try:
            usual = _FACTORS.get((unit_text, unit))
            conversion = (usual, Decimal(0)) if usual else _conversion(unit_text, unit)
        except ValueError:
            limit = f"{_allowed(unit)}; {unit_text!r} is not a known unit (upper and lower case matter)"
            raise refusal(field, raw, limit, cure) from None
    if conversion is None:
        raise refusal(field, raw, _allowed(unit), cure)
    factor, offset = conversion
    return _bounded(number * factor + offset, raw, field, cure)


def exact_number(raw: object, field: str, sample: str = "0.5") -> Decimal:
    """A plain number, given as a number or as text, exactly; raises InvalidInput, whose cure shows the sample.

    >>> exact_number(0.31, "n")
    Decimal('0.31')
    """
    cure = f"write a number such as {sample}"
    if isinstance(raw, str):
        match = _QUANTITY.fullmatch(raw[: LONGEST_TEXT + 1])
        if match is None or len(raw) > LONGEST_TEXT or match[2]:
            raise refusal(field, raw, "a plain number without unit", cure)
        return _decimal(match[1], raw, field, cure)
    if not is_number(raw):
        raise refusal(field, raw, "a plain number", cure)
    return _decimal(_digits(raw), raw, field, cure)


def exact_share(raw: object, field: str, sample: str) -> float:
    """A part of one, also in per cent, at the digits of a quantity; raises InvalidInput, whose cure shows the sample.

    >>> exact_share("3 %", "error", "5 %"), exact_share(0.03, "error", "5 %")
    (0.03, 0.03)
    """
    if isinstance(raw, str) and (text := raw.rstrip()).endswith("%"):
        return round_quantity(exact_number(text[:-1], field, sample) / 100)
    return round_quantity(exact_number(raw, field, sample))


def is_number(raw: object) -> TypeGuard[float | Decimal]:
    """Whether a value is a number; true and false are not."""
    return isinstance(raw, Real | Decimal) and not isinstance(raw, bool)


def dimension_of(unit: str) -> str:
    """Name of the dimension of an SI unit: "speed" for "m s-1".

    >>> dimension_of("m s-1"), dimension_of("1")
    ('speed', 'plain number')
    """
    if unit == "1":
        return "plain number"
    return _DIMENSIONS[unit][0] if unit in _DIMENSIONS else f"quantity in {unit}"


def a_quantity(unit: str) -> str:
    """The dimension of an SI unit with its article.

    >>> a_quantity("rad"), a_quantity("m")
    ('an angle', 'a length')
    """
    dimension = dimension_of(unit)
    return f"{'an' if dimension[0] in 'aeiou' else 'a'} {dimension}"


def _split(raw: object, unit: str, field: str, bounds: Bounds) -> tuple[str, str]:
    """Number text and unit text of a quantity."""
    if isinstance(raw, str) and (fraction := _OF_AN_INCH.fullmatch(raw[: LONGEST_TEXT + 1])):
        whole, above, below, inch = fraction.groups()
        return str(int(whole or 0) + Decimal(above) / Decimal(below)), inch
    match = _QUANTITY.fullmatch(raw) if isinstance(raw, str) and len(raw) <= LONGEST_TEXT else None
    if match is None:
        raise refusal(field, raw, _allowed(unit), _cure(unit, bounds))
    return match[1], (match[2] or "").strip()


def _digits(raw: float | Decimal) -> str:
    """A number as decimal text; a float as the shortest text that reads back as itself."""
    if isinstance(raw, Decimal | Rational):
        return str(raw) if abs(raw) < 10**LARGEST_EXPONENT else "inf"
    return repr(float(raw))


def _decimal(text: str, raw: object, field: str, cure: str) -> Decimal:
    try:
        return _bounded(Decimal(text), raw, field, cure)
    except DecimalException:
        raise refusal(field, raw, "a finite number", cure) from None


def _bounded(number: Decimal, raw: object, field: str, cure: str) -> Decimal:
    if not number.is_finite() or (number and abs(number.adjusted()) > LARGEST_EXPONENT):
        raise refusal(field, raw, "a finite number within the range of a double", cure)
    return number


def _degrees(value: float) -> str | None:
    """An angle (rad) in degrees; None where so many digits of them are another angle."""
    degrees = f"{Decimal(value) * 180 / PI:.{DEGREES_DIGITS}g}"
    if round_quantity(Decimal(degrees) * PI / 180) != round_quantity(value):
        return None
    return f"{float(degrees):.{DEGREES_DIGITS}g} deg"


def _allowed(unit: str) -> str:
    return f"{a_quantity(unit)} with its unit"


def _sample_units(unit: str) -> tuple[str, ...]:
    return _DIMENSIONS[unit][1] if unit in _DIMENSIONS else (unit,)


@lru_cache(maxsize=1024)  # of declared bounds; asked for with every value
def _cure(unit: str, bounds: Bounds) -> str:
    """A sample of an allowed value."""
    sample = f"1 {_sample_units(unit)[0]}"
    if bounds != UNBOUNDED and not _inside(Decimal(1), _sample_units(unit)[0], unit, bounds):
        sample = readable(bounds.nearest(0.0), unit)
    return f"write for example '{sample}'"


def _cure_for_bare_number(number: Decimal, unit: str, bounds: Bounds) -> str:
    """The number with each usual unit that makes it an allowed value."""
    digits = f"{number:.{SIGNIFICANT_DIGITS}g}"
    samples = [
        f"'{digits} {sample}'"
        for sample in _sample_units(unit)
        if bounds == UNBOUNDED or _inside(number, sample, unit, bounds)
    ]
    return "write " + " or ".join(samples) if samples else _cure(unit, bounds)


def _inside(number: Decimal, unit_text: str, unit: str, bounds: Bounds) -> bool:
    """Whether a number in a unit is an allowed value."""
    value = round_quantity(convert(number, unit_text, unit, ""))
    return bounds.nearest(value) == value


@lru_cache(maxsize=4096)  # user text: bounded, and far more than the units of one sweep
def _conversion(unit_text: str, unit: str) -> tuple[Decimal, Decimal] | None:
    """Factor and offset from a unit to an SI unit, None to one of another dimension; the offset is zero but for degC.

    Raises ValueError where the text is no unit. To pint an angle is a plain number, as a percent is; it still knows
    which of its units are made of radians.
    """
    from pint import DimensionalityError

    registry = _registry()
    try:
        given_unit = registry.parse_units(_expression(unit_text))
        target_unit = registry.parse_units(_expression(unit))
        zero = registry.Quantity(Decimal(0), given_unit).to(target_unit).magnitude
        unity = registry.Quantity(Decimal(1), given_unit).to(target_unit).magnitude
        basis = registry.get_root_units(given_unit)[1]
        target_basis = registry.get_root_units(target_unit)[1]
    except DimensionalityError:
        return None
    except Exception as error:  # what pint raises for a text that is no unit has no common base
        raise ValueError(f"{unit_text!r} is not a unit") from error
    return (Decimal(unity - zero).normalize(), Decimal(zero).normalize()) if basis == target_basis else None


def _expression(unit_text: str) -> str:
    """A unit, UDUNITS spelling included ("kg m-3"), in the spelling of pint; raises ValueError.

    >>> _expression("J/(kg K)"), _expression("m s-1"), _expression("g/cm³")
    ('J/(kg*K)', 'm*s**-1', 'g/cm**3')
    """
    text = re.sub(r"\s*([*/()])\s*", r"\1", unit_text.translate(_SUPERSCRIPTS).strip())
    if text.startswith(("1/", "/")):
        return "1/" + _expression(text.partition("/")[2])
    if not re.fullmatch(rf"(?:{_WORD.pattern}|(?<!\*)\*(?!\*)|[/() ])+", text):
        raise ValueError(f"{unit_text!r} is not a unit")
    return (
        _WORD.sub(lambda word: f"{word[1]}**{word[2]}" if word[2] else word[1], text)
        .replace(" ", "*")
        .replace(")(", ")*(")
    )


@cache
def _registry() -> "UnitRegistry[Decimal]":
    """The one unit registry of the process, computing in decimals."""
    from pint import UnitRegistry

    return UnitRegistry(non_int_type=Decimal)
