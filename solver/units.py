"""Annotations of the numbers in a record: unit, meaning, bounds, and where a number comes from.

Inside the solver and the studies every quantity is a plain float in SI; an annotation is data that the
input (unit parsing), the cube (``units`` attribute), the API schema and the tests read.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Any, TypeVar, get_type_hints

Mark = TypeVar("Mark")


@dataclass(frozen=True)
class Unit:
    """The SI unit of an annotated float, in UDUNITS spelling ("m s-1")."""

    symbol: str


@dataclass(frozen=True)
class Described:
    """A field that a person sets, in a sweep or in a material file; a number has inclusive bounds in SI."""

    meaning: str
    minimum: float | None = None
    maximum: float | None = None
    # What solids that impacts are about have, in SI: a value beyond is allowed and doubted. Zero where the minimum is
    # zero is matter that goes without.
    usual: tuple[float, float] | None = None


@dataclass(frozen=True)
class Below:
    """A number that makes sense only below (or up to) that of another field of its record."""

    field: str
    or_equal: bool = False


@dataclass(frozen=True)
class FromMaterial:
    """A field of a model that takes a number of the material, by its dotted path."""

    path: str
    above_zero: bool = False  # zero is as good as none


Dimensionless = Annotated[float, Unit("1")]
Radian = Annotated[float, Unit("rad")]
Metre = Annotated[float, Unit("m")]
Second = Annotated[float, Unit("s")]
Kelvin = Annotated[float, Unit("K")]
Pascal = Annotated[float, Unit("Pa")]
PerPascal = Annotated[float, Unit("Pa-1")]
PerKelvin = Annotated[float, Unit("K-1")]
PerSecond = Annotated[float, Unit("s-1")]
MetrePerSecond = Annotated[float, Unit("m s-1")]
MetrePerSecondSquared = Annotated[float, Unit("m s-2")]
KilogramPerCubicMetre = Annotated[float, Unit("kg m-3")]
JoulePerKilogram = Annotated[float, Unit("J kg-1")]
JoulePerKilogramKelvin = Annotated[float, Unit("J kg-1 K-1")]

# Numbers of a material that several models take.
Density = Annotated[KilogramPerCubicMetre, FromMaterial("density")]
HeatCapacity = Annotated[JoulePerKilogramKelvin, FromMaterial("thermal.heat_capacity")]
RoomTemperature = Annotated[Kelvin, FromMaterial("thermal.room_temperature")]


@cache
def marked(record: type, kind: type[Mark]) -> Mapping[str, Mark]:
    """The first mark of a kind of each field of a record that carries one, also inside ``Metre | None``."""
    found = {name: [mark for mark in marks if isinstance(mark, kind)] for name, marks in _marks(record).items()}
    return {name: marks[0] for name, marks in found.items() if marks}


@cache
def _marks(record: type) -> Mapping[str, list[Any]]:
    """All marks of each field of a record."""
    return {name: marks_of(hint) for name, hint in get_type_hints(record, include_extras=True).items()}


def marks_of(hint: Any) -> list[Any]:
    """Marks of an annotation and of the types inside it."""
    marks = list(getattr(hint, "__metadata__", ()))
    inside = (hint.__origin__,) if marks else getattr(hint, "__args__", ())
    for part in inside:
        marks += marks_of(part)
    return marks
