"""Tables of shots: units in the header or beside the number, every row named when refused."""

import pytest

from studies.errors import InvalidInput
from studies.observations import Known, Observation, read_observations
from studies.parameters import Parameter, Value

KNOWN = Known(
    quantities={"hole_diameter": "m", "crater_depth_over_diameter": "1"},
    parameters={
        "speed": Parameter(name="speed", kind="quantity", unit="m s-1", minimum=100.0),
        "target": Parameter(name="target", kind="material"),
        "target.strength.A": Parameter(name="A", kind="quantity", unit="Pa"),
    },
    materials=("copper-ofhc",),
)

TABLE = """\
# shots of last week
speed [km/s], target, quantity, value [mm], uncertainty, source

6, copper-ofhc, hole_diameter, 19.0, 0.3 mm, "Ma (2005), Fig. 3.2"
2.0 km/s, , hole_diameter, 1.5 cm, , own shot 17
"""


def refused(given: object) -> str:
    with pytest.raises(InvalidInput) as caught:
        read_observations(given, KNOWN)
    return str(caught.value)


def test_read_observations__takes_units_from_header_or_cell() -> None:
    first, second = read_observations(TABLE, KNOWN)
    parameters: dict[str, Value] = {"speed": 6000.0, "target": "copper-ofhc"}
    assert first == Observation("hole_diameter", 0.019, 0.0003, "Ma (2005), Fig. 3.2", parameters)
    assert second == Observation("hole_diameter", 0.015, None, "own shot 17", {"speed": 2000.0})


def test_read_observations__takes_a_list_of_mappings() -> None:
    row = {"speed": "6 km/s", "quantity": "hole_diameter", "value": "19 mm", "source": "shot 1"}
    (shot,) = read_observations([row], KNOWN)
    assert (shot.value, shot.uncertainty) == (0.019, None)


def test_document__reads_back_as_the_same_shots() -> None:
    shots = read_observations(TABLE, KNOWN)
    rows = [shot.document(KNOWN) for shot in shots]
    assert read_observations(rows, KNOWN) == shots


def test_read_observations__of_a_column_given_twice_is_refused() -> None:
    table = "quantity,value,source,speed [km/s],speed [m/s]\nhole_diameter,19 mm,x,3,9000\n"
    with pytest.raises(InvalidInput, match="each column once"):
        read_observations(table, KNOWN)


def test_read_observations__takes_a_plain_ratio() -> None:
    table = "quantity,value,source\ncrater_depth_over_diameter,0.55,x\n"
    assert read_observations(table, KNOWN)[0].value == 0.55


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("6,hole_diameter,,0.3 mm,x", ["line 3", "value"]),
        ("6,hole_diameter,19,0.3 mm,x", ["line 3: value", "19 mm"]),
        ("6,hole_diameter,19 kg,0.3 mm,x", ["line 3: value", "length"]),
        ("6,hole_diameter,-19 mm,0.3 mm,x", ["line 3: value", "0 um"]),
        ("6,hole_diameter,19 mm,-1 mm,x", ["line 3: uncertainty"]),
        ("6,hole_diametre,19 mm,0.3 mm,x", ["line 3: quantity", "did you mean 'hole_diameter'"]),
        ("6,hole_diameter,19 mm,0.3 mm,", ["line 3", "source"]),
        ("6,hole_diameter,19 mm", ["line 3", "3 cells", "5 cells"]),
        ("1e-3,hole_diameter,19 mm,,x", ["line 3: speed", "100 m/s"]),
        ("nan,hole_diameter,19 mm,,x", ["line 3: speed"]),
    ],
)
def test_read_observations__names_the_row_and_the_column(line: str, words: list[str]) -> None:
    table = "speed [km/s],quantity,value,uncertainty,source\n"
    message = refused(table + "3,hole_diameter,12 mm,,x\n" + line)
    assert all(word in message for word in words), message


def test_read_observations__tells_every_row_that_is_wrong() -> None:
    message = refused("quantity,value,source\nhole_diameter,3,x\nhole_diameter,3 kg,x\n")
    assert "line 2" in message
    assert "line 3" in message


@pytest.mark.parametrize(
    "given", [None, 3, "", "\n\n", {"a": 1}, [3], [["speed"]], [{3: "x"}], 'a,"b\n']
)
def test_read_observations__of_no_table_is_refused(given: object) -> None:
    refused(given)


def test_read_observations__of_an_unknown_column_gives_the_nearest() -> None:
    assert "did you mean 'speed'" in refused("sped,quantity,value,source\n1,hole_diameter,1 mm,x")


def test_read_observations__takes_a_constant_of_a_material() -> None:
    table = "target.strength.A [MPa],quantity,value [mm],source\n90,hole_diameter,15,x"
    assert read_observations(table, KNOWN)[0].parameters == {"target.strength.A": 90e6}
