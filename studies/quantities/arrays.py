"""Numbers as Python libraries have them, in place of those that a document writes: arrays, pint, triples of xarray."""

from collections.abc import Mapping
from typing import Any

from studies.quantities.parameters import Plain


def plain(value: Any) -> Plain:
    """A value, or a document with such values, as YAML and JSON have it; what is known no better stays as it is.

    Quantities of pint, arrays of xarray with ``units``, and numbers with their unit beside them become texts with the
    unit, arrays of NumPy lists; a list of triples (name, values, unit) becomes a mapping, as axes are.

    >>> plain({"axes": [("speed", (2.0, 2.5), "km/s")], "fixed": {"plate_thickness": (2, "mm")}})
    {'axes': {'speed': ['2.0 km/s', '2.5 km/s']}, 'fixed': {'plate_thickness': '2 mm'}}
    """
    if isinstance(value, Mapping):
        return {key: plain(part) for key, part in value.items()}
    if hasattr(value, "magnitude") and hasattr(value, "units"):  # pint
        return _with_unit(value.magnitude, f"{value.units:~C}")
    if isinstance(getattr(value, "attrs", None), Mapping) and "units" in value.attrs:  # xarray, pandas
        return _with_unit(value, str(value.attrs["units"]))
    if _is_with_unit(value):
        return _with_unit(value[-2], value[-1])
    if isinstance(value, list | tuple):
        if value and all(_is_with_unit(part) and len(part) == 3 for part in value):
            return {part[0]: plain(part) for part in value}
        return [plain(part) for part in value]
    return _bare(value)


def _is_with_unit(value: Any) -> bool:
    """Whether a value is (numbers, unit), or (name, numbers, unit)."""
    if not isinstance(value, tuple) or len(value) not in (2, 3) or not all(isinstance(s, str) for s in value[:-2]):
        return False
    numbers = _bare(value[-2])
    each = numbers if isinstance(numbers, list | tuple) else [numbers]
    return isinstance(value[-1], str) and bool(each) and all(isinstance(number, int | float) for number in each)


def _with_unit(values: Any, unit: str) -> Plain:
    numbers = _bare(values)
    if isinstance(numbers, list | tuple):
        return [_with_unit(number, unit) for number in numbers]
    return f"{numbers} {unit}" if unit not in ("", "1", "dimensionless") else numbers


def _bare(value: Any) -> Any:
    """Numbers of an array, or of a scalar of NumPy, as those of Python."""
    inside = getattr(value, "values", value)  # of xarray and pandas
    return inside.tolist() if hasattr(inside, "tolist") else value
