"""Tables of shots: what they may hold, and that a refusal names every row."""

import pytest

from studies import observations, scenarios
from studies.materials.schema import CONFIDENCES
from studies.observations import AllowedNames, Observation, read_observations
from studies.observations.compared import FEWEST, StoredShot, bias_and_scatter, compared_shots
from studies.quantities.findings import InvalidInput
from studies.quantities.parameters import Parameter, Value
from studies.sweeps.reading import vocabulary
from tests.samples import needs

KNOWN = AllowedNames(
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


def test_table__takes_units_from_header_or_cell() -> None:
    first, second = read_observations(TABLE, KNOWN)
    parameters: dict[str, Value] = {"speed": 6000.0, "target": "copper-ofhc"}
    assert first == Observation("hole_diameter", 0.019, 0.0003, "Ma (2005), Fig. 3.2", parameters)
    assert second == Observation("hole_diameter", 0.015, None, "own shot 17", {"speed": 2000.0})


@pytest.mark.parametrize(
    "scenario",
    ["thick_plate", "thin_plate", *(pytest.param(name, marks=needs(name)) for name in ("taylor_bar", "plate_impact"))],
)
def test_published_tables__are_read_by_their_scenario(scenario: str) -> None:
    """Each file that ships is read by exactly one scenario, with a source and a word of confidence a shot."""
    allowed = vocabulary(scenario, dict.fromkeys(scenarios.load(scenario).materials, ()), {})
    own = {
        "taylor_bar": "taylor-bars-",
        "thick_plate": "craters",
        "thin_plate": "holes",
        "plate_impact": "plate-impacts",
    }[scenario]
    tables = [name for name in observations.names() if name.startswith(own)]
    assert tables
    for name in tables:
        shots = read_observations(name, allowed)
        assert all(shot.source and shot.confidence in CONFIDENCES for shot in shots), name
        assert all(shot.parameters["speed"] for shot in shots), name


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("6,hole_diameter,,0.3 mm,x", ["line 3", "value"]),
        ("6,hole_diameter,19 kg,0.3 mm,x", ["line 3: value", "length"]),
        ("6,hole_diameter,-19 mm,0.3 mm,x", ["line 3: value", "0 mm"]),
        ("6,hole_diametre,19 mm,0.3 mm,x", ["line 3: quantity", "did you mean 'hole_diameter'"]),
        ("6,hole_diameter,19 mm,0.3 mm,", ["line 3", "source"]),
        ("6,hole_diameter,19 mm", ["line 3", "3 cells", "5 cells"]),
    ],
)
def test_refusal__names_the_row_and_the_column(line: str, words: list[str]) -> None:
    table = "speed [km/s],quantity,value,uncertainty,source\n"
    message = refused(table + "3,hole_diameter,12 mm,,x\n" + line)
    assert all(word in message for word in words), message


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("sped,quantity,value,source\n1,hole_diameter,1 mm,x", "did you mean 'speed'"),
        ("quantity,value,source,speed [km/s],speed [m/s]\nhole_diameter,1 mm,x,3,9000", "each column"),
        (3, "CSV text or a list"),
        ([3], "a mapping"),
        ('a,"b\n', "CSV text"),
        ("hole_diametre,source\n1 mm,x", "did you mean 'hole_diameter'"),
        ("hole_diameter,value,source\n1 mm,2 mm,x", "one way to name quantities"),
        ("hole_diameter,source\n,x", "one measured quantity a row"),
        ("\n" * 100_001, "at most 100000 lines"),
    ],
)
def test_refusal__says_what_is_wrong_with_a_table(given: object, words: str) -> None:
    assert words in refused(given)


@pytest.mark.claim("mend-again", "bias-from-five-shots")
def test_bias__is_an_interval_from_five_shots_on() -> None:
    """A bias of whipple is the 95 % interval of a mean over five shots or more of a metal, and fewer have none."""
    rows = [StoredShot(simulated=1.0 + share, observed=1.0) for share in (-0.2, -0.1, 0.0, 0.1, 0.2)]
    # t(0.975, 4) = 2.776, and the standard deviation over the root of 5 is 0.0707.
    count, bias, scatter = bias_and_scatter(rows)
    assert count == 5
    assert bias == pytest.approx((-0.1963, 0.1963), abs=1e-4)
    assert scatter == pytest.approx(0.1581, abs=1e-4)
    assert bias_and_scatter(rows[:4]) == (4, None, None)
    groups = [group for group in compared_shots() if group.shots < FEWEST]
    assert groups
    assert all(group.bias is None and group.scatter is None for group in groups)
