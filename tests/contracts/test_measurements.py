"""Every measurement states what it is, reads every state of its kind, and ignores the order of particles."""

import math
from typing import Any

import numpy as np
import pytest

from studies import measurements
from studies.measurements import RESOLUTION_IN_CELLS, History
from studies.quantities.measured import ERROR_UNKNOWN
from tests.studies.measurements.states import CELL, STATES, looks_at, read, reordered

UNITS = {"m", "m3", "s", "1", "Pa", "m s-1", "kg m-3", "kg", "J", "N s", "kg m s-1", "s-1"}
PAIRS = [(name, state) for name in measurements.names() for state in STATES[looks_at(name)]]


@pytest.fixture(params=PAIRS, ids=lambda pair: "-".join(pair))
def pair(request: pytest.FixtureRequest) -> tuple[str, Any]:
    name, state = request.param
    return name, STATES[looks_at(name)][state]()


@pytest.mark.parametrize("name", measurements.names())
def test_measurement__states_what_it_is(name: str) -> None:
    measurement = measurements.load(name)
    assert measurement.unit in UNITS
    assert len(measurement.meaning) > 10
    assert measurement.version >= 1
    assert (looks_at(name) is History) == bool(measurement.follows)
    assert not any(measurements.load(other).follows for other in measurement.follows)


def test_measurement__has_a_value_with_its_uncertainty_or_a_flag(pair: tuple[str, Any]) -> None:
    reading = read(*pair)
    assert math.isfinite(reading.value) or reading.flags
    if math.isfinite(reading.value):
        assert all(math.isfinite(part) and part >= 0.0 for part in reading.parts.values())
        # A nominal length is read off no grid.
        if measurements.load(pair[0]).unit == "m" and not pair[0].startswith("fragment_size"):
            assert reading.parts["resolution"] == RESOLUTION_IN_CELLS * CELL


@pytest.mark.claim("mend-again", "no-error-of-zero")
def test_uncertainty__is_no_zero_and_where_unknown_says_so() -> None:
    """No measurement states an uncertainty of 0: where nothing tells an error there is none, and a flag says so."""
    for name, state in PAIRS:
        measurement, reading = measurements.load(name), read(name, STATES[looks_at(name)][state]())
        if math.isfinite(reading.value):
            size, flags = measurement.uncertainty_by(reading.parts)
            assert size is None or size > 0.0, name
            is_told = measurement.is_outcome or measurement.mesh_determined
            assert flags == ((ERROR_UNKNOWN,) if size is None and not is_told else ()), name


def test_measurement__does_not_depend_on_the_order_of_particles(pair: tuple[str, Any]) -> None:
    name, state = pair
    if isinstance(state, History):
        return
    first, second = read(name, state), read(name, reordered(state))
    assert first.flags == second.flags
    # Sums run in another order.
    assert np.isclose(first.value, second.value, rtol=1e-10, atol=1e-10 * CELL, equal_nan=True)
