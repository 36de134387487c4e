"""Parameters: read off a record's annotations, checked all at once, defaults filled in."""

from dataclasses import dataclass, field
from typing import Any, Literal

import pytest

from solver.units import Dimensionless, Metre, MetrePerSecond
from studies.errors import InvalidInput
from studies.parameters import MaterialName, declared, describe, parse_parameters


@dataclass(frozen=True, kw_only=True)
class Shot:
    """A record with a field of each kind."""

    speed: MetrePerSecond = field(metadata={"meaning": "impact speed", "minimum": 1.0})
    target: MaterialName
    length: Metre | None = None
    shape: Literal["sphere", "cylinder"] = "sphere"
    courant: Dimensionless = field(default=0.1 + 0.2, metadata={"maximum": 1.0})
    layers: int = 1
    heating: bool = True
    note: str = "none"


GIVEN = {"speed": "6 km/s", "target": "copper-ofhc"}


def refused(given: dict[str, Any], **options: Any) -> str:
    with pytest.raises(InvalidInput) as caught:
        parse_parameters(Shot, given, "fixed", **options)
    return str(caught.value)


def test_declared__reads_kind_unit_and_bounds() -> None:
    known = declared(Shot)
    kinds = {name: parameter.kind for name, parameter in known.items()}
    assert list(kinds.values()) == [
        "quantity",
        "material",
        "quantity",
        "choice",
        "quantity",
        "integer",
        "boolean",
        "text",
    ]
    assert (known["speed"].unit, known["speed"].minimum, known["speed"].required) == (
        "m s-1",
        1.0,
        True,
    )
    assert (known["length"].optional, known["length"].required) == (True, False)
    assert known["shape"].choices == ("sphere", "cylinder")
    assert known["target"].unit is None


def test_declared__refuses_an_annotation_it_cannot_check() -> None:
    @dataclass(frozen=True)
    class Wrong:
        speed: float

    with pytest.raises(TypeError, match="speed"):
        declared(Wrong)


def test_parse_parameters__fills_in_rounded_defaults_in_order() -> None:
    values = parse_parameters(Shot, GIVEN)
    assert list(values) == list(declared(Shot))
    assert values["speed"] == 6000.0
    assert values["courant"] == 0.3


def test_parse_parameters__takes_null_where_it_is_an_answer() -> None:
    assert parse_parameters(Shot, {**GIVEN, "length": None})["length"] is None
    assert "fixed.speed: null" in refused({**GIVEN, "speed": None})


def test_parse_parameters__takes_bare_si_from_behind_the_door_alone() -> None:
    assert parse_parameters(Shot, {**GIVEN, "speed": 6000.0}, si=True)["speed"] == 6000.0
    assert "write '6000.0 km/s'" in refused({**GIVEN, "speed": 6000.0})
    assert "finite" in refused({**GIVEN, "speed": float("nan")}, si=True)
    assert "speed from 1 m/s" in refused({**GIVEN, "speed": -5.0}, si=True)


def test_parse_parameters__tells_everything_at_once() -> None:
    message = refused({"sped": 1, "shape": "cube", "courant": 2, "layers": 1.5, "heating": 1})
    for words in (
        "fixed.sped",
        "did you mean 'speed'",
        "fixed.shape",
        "nearest allowed value is 1",
    ):
        assert words in message
    for name in ("layers", "heating", "speed: nothing", "target: nothing"):
        assert f"fixed.{name}" in message


def test_parse_parameters__knows_the_materials_it_is_given() -> None:
    assert "did you mean 'copper-ofhc'" in refused(
        {**GIVEN, "target": "copper"}, materials=["copper-ofhc", "lead"]
    )


def test_describe__is_plain() -> None:
    (first, *_) = describe(declared(Shot).values())
    assert first["name"] == "speed"
    assert first["limit"] == "a speed from 1 m/s"
