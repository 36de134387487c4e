"""Units at the door: exact, finite, of the right dimension, or refused with a cure."""

import math
import re
from dataclasses import dataclass
from decimal import Decimal
from typing import Annotated

import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.units import Described, Radian
from studies.quantities.findings import InvalidInput
from studies.quantities.parameters import parse_parameters
from studies.quantities.units import _FACTORS, _conversion, parse_quantity, readable, round_quantity

UNITS = ["m", "s", "Pa", "m s-1", "kg m-3", "K", "J kg-1 K-1", "rad"]


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("6 km/s", "m s-1", "6000"),
        ("6km/s", "m s-1", "6000"),
        ("1 rad", "rad", "1"),
        (" 2.4 mm ", "m", "0.0024"),
        ("2.4e-3 m", "m", "0.0024"),
        ("30 µs", "s", "0.00003"),
        ("100 MPa", "Pa", "1e8"),
        ("8.93 g/cm3", "kg m-3", "8930"),
        ("8.93 g/ccm", "kg m-3", "8930"),
        ("1/8 in", "m", "0.003175"),
        ('1 1/8"', "m", "0.028575"),
        ('0.125"', "m", "0.003175"),
        ("3/16 inches", "m", "0.0047625"),
        ("5 mil", "m", "0.000127"),
        ("5 mils", "m", "0.000127"),
        ("383 J/(kg K)", "J kg-1 K-1", "383"),
        ("20 degC", "K", "293.15"),
        ("1 1/s", "s-1", "1"),
        ("0.31", "1", "0.31"),
    ],
)
def test_parse_quantity__is_exact(text: object, unit: str, value: str) -> None:
    assert parse_quantity(text, unit, "field") == Decimal(value)


@pytest.mark.parametrize(
    ("given", "unit", "word"),
    [
        (6, "m s-1", "write '6 km/s' or '6 m/s'"),
        ("2 kg", "m s-1", "speed"),
        ("2 kg", "m", "length"),
        ("1/8 mm", "m", "not a known unit"),
        ("1/0 in", "m", "not a known unit"),
        ("5 mil", "kg m-3", "density"),
        ("2 furlong/moon", "m s-1", "not a known unit"),
        ("2 M", "m", "length"),
        ("6,1 km/s", "m s-1", "speed"),
        ("1e999 m", "m", "finite"),
        ("1 m**9**9", "m", "not a known unit"),
        ("__import__('os')", "m", "length"),
        ("1 m" + " " * 200, "m", "length"),
        (float("nan"), "m", "finite"),
        ("30", "rad", "an angle with its unit"),
        ("30 percent", "rad", "an angle with its unit"),
        ("1 mm/mm", "rad", "an angle with its unit"),
        ("30 deg", "1", "plain number"),
        ("30 rad/s", "s-1", "rate"),
        (float("nan"), "1", "finite"),
        ("0.5 mm", "1", "plain number"),
        (True, "1", "plain number"),
        (None, "m", "length"),
        ({"value": 1}, "1", "plain number"),
    ],
)
def test_parse_quantity__refuses_with_a_cure(given: object, unit: str, word: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        parse_quantity(given, unit, "fixed.speed")
    (finding,) = caught.value.findings
    assert finding.field == "fixed.speed"
    assert word in str(finding)
    assert finding.cure
    assert len(finding.value) <= 60


def test_usual_units__have_the_factors_of_pint() -> None:
    """Each unit that is known without pint is worth what pint says, but for spellings that it does not know."""
    spelled = {"mil": "thou", "mils": "thou", '"': "inch", "″": "inch", "g/ccm": "g/cm3"}
    for (text, unit), factor in _FACTORS.items():
        conversion = _conversion(spelled.get(text, text), unit)
        assert conversion is not None
        assert float(factor) == pytest.approx(float(conversion[0]), rel=1e-15), text


@dataclass(frozen=True, kw_only=True)
class Bounded:
    """A field whose bound has more digits than a value keeps."""

    angle: Annotated[Radian, Described("", minimum=0.0, maximum=math.radians(75.0))] = 0.0


def test_bound__is_itself_allowed_and_is_told_in_degrees() -> None:
    bound = math.radians(75.0)
    assert parse_parameters(Bounded, {"angle": "75 deg"})["angle"] == pytest.approx(bound)
    assert parse_parameters(Bounded, {"angle": bound}, si=True)["angle"] == pytest.approx(bound)
    for angle, end in (("75.0001 deg", 75), ("-1 deg", 0)):
        with pytest.raises(InvalidInput, match=f"from 0 deg to 75 deg; the nearest allowed value is {end} deg"):
            parse_parameters(Bounded, {"angle": angle})


@given(st.floats(1e-9, 1e15), st.sampled_from(UNITS))
def test_readable__reads_back_as_the_same_quantity(value: float, unit: str) -> None:
    value = round_quantity(value)
    assert round_quantity(parse_quantity(readable(value, unit), unit, "field")) == value


@pytest.mark.parametrize("given", [float("nan"), float("inf"), float("-inf"), "1e999", 6, 10**100])
@pytest.mark.parametrize("unit", ["m s-1", "m", "rad", "s-1"])
def test_parse_quantity__takes_the_cure_that_it_offers(given: object, unit: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        parse_quantity(given, unit, "field")
    offers = re.findall(r"'([^']*)'", caught.value.findings[0].cure)
    assert offers
    for offer in offers:
        assert parse_quantity(offer, unit, "field").is_finite()
