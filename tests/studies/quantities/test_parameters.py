"""Bounds of parameters: themselves allowed, and told in a unit that people write."""

import math
from dataclasses import dataclass
from typing import Annotated

import pytest

from solver.units import Described, Radian
from studies.quantities.findings import InvalidInput
from studies.quantities.parameters import parse_parameters


@dataclass(frozen=True, kw_only=True)
class Bounded:
    """A field whose bound has more digits than a value keeps."""

    angle: Annotated[Radian, Described("", minimum=0.0, maximum=math.radians(75.0))] = 0.0


def test_bound__is_itself_allowed_though_it_has_more_digits_than_a_value() -> None:
    bound = math.radians(75.0)
    assert parse_parameters(Bounded, {"angle": "75 deg"})["angle"] == pytest.approx(bound)
    assert parse_parameters(Bounded, {"angle": bound}, si=True)["angle"] == pytest.approx(bound)


@pytest.mark.parametrize("angle", ["75.0001 deg", "90 deg", "-1 deg"])
def test_bound__of_an_angle_is_told_in_degrees(angle: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        parse_parameters(Bounded, {"angle": angle})
    (finding,) = caught.value.findings
    assert finding.limit == "an angle from 0 deg to 75 deg"
    assert finding.cure in [f"the nearest allowed value is {end} deg" for end in (0, 75)]
