"""Parameters: read off a record's annotations, checked all at once, defaults filled in."""

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import pytest

from solver.units import Described, Dimensionless, Metre, MetrePerSecond, Radian
from studies.quantities.findings import Finding, InvalidInput
from studies.quantities.parameters import MaterialName, declared, parse_parameters


@dataclass(frozen=True, kw_only=True)
class Shot:
    """A record with a field of each kind."""

    speed: Annotated[MetrePerSecond, Described("impact speed", minimum=1.0)]
    target: MaterialName
    length: Metre | None = None
    shape: Literal["sphere", "cylinder"] = "sphere"
    courant: Annotated[Dimensionless, Described("", maximum=1.0)] = 0.1 + 0.2
    layers: int = 1
    heating: bool = True
    note: str = "none"


GIVEN = {"speed": "6 km/s", "target": "copper-ofhc"}


def test_parse_parameters__fills_in_rounded_defaults_in_order() -> None:
    values = parse_parameters(Shot, GIVEN)
    assert list(values) == list(declared(Shot))
    assert values["speed"] == 6000.0
    assert values["courant"] == 0.3


@dataclass(frozen=True, kw_only=True)
class Bounded:
    """Fields whose bounds matter: one has more digits than a value keeps."""

    angle: Annotated[Radian, Described("", minimum=0.0, maximum=math.radians(75.0))] = 0.0
    share: Annotated[Dimensionless, Described("", minimum=2.0, maximum=512.0)] = 2.0
    count: Annotated[int, Described("", minimum=1, maximum=6)] = 2


def finding_of(name: str, value: Any) -> Finding:
    with pytest.raises(InvalidInput) as caught:
        parse_parameters(Bounded, {name: value})
    (finding,) = caught.value.findings
    return finding


def test_bound__is_itself_allowed_though_it_has_more_digits_than_a_value() -> None:
    bound = math.radians(75.0)
    assert parse_parameters(Bounded, {"angle": "75 deg"})["angle"] == pytest.approx(bound)
    assert parse_parameters(Bounded, {"angle": bound}, si=True)["angle"] == pytest.approx(bound)


@pytest.mark.parametrize("angle", ["75.0001 deg", "90 deg", "-1 deg"])
def test_bound__of_an_angle_is_told_in_degrees(angle: str) -> None:
    finding = finding_of("angle", angle)
    assert finding.limit == "an angle from 0 deg to 75 deg"
    assert finding.cure in [f"the nearest allowed value is {end} deg" for end in (0, 75)]
