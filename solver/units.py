"""Unit aliases for annotations: a float that says what it is measured in.

Inside the solver and the studies every quantity is a plain float in SI; the alias is data that the
door (unit parsing), the cube (``units`` attribute), the API schema and the tests read.
"""

from dataclasses import dataclass
from typing import Annotated, Any, get_type_hints


@dataclass(frozen=True)
class Unit:
    """The SI unit of an annotated float, in UDUNITS spelling ("m s-1")."""

    symbol: str


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
KilogramPerCubicMetre = Annotated[float, Unit("kg m-3")]
JoulePerKilogram = Annotated[float, Unit("J kg-1")]
JoulePerKilogramKelvin = Annotated[float, Unit("J kg-1 K-1")]


def units_of(record: type) -> dict[str, str]:
    """The unit symbol of each field of a record that carries one."""
    hints: dict[str, Any] = get_type_hints(record, include_extras=True)
    return {name: mark.symbol for name, hint in hints.items() for mark in _marks(hint)}


def _marks(hint: Any) -> list[Unit]:
    """Units found in a hint, also inside ``Metre | None``."""
    found = [mark for mark in getattr(hint, "__metadata__", ()) if isinstance(mark, Unit)]
    for argument in getattr(hint, "__args__", ()):
        found += _marks(argument)
    return found
