"""Every measurement states what it is, reads every state of its kind, and ignores the order of particles."""

import math
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest

from studies import measurements
from studies.measurements import RESOLUTION_IN_CELLS, History, Reading
from studies.quantities.measured import ERROR_UNKNOWN
from tests.studies.measurements.states import CELL, looks_at, read, reordered, states

UNITS = {"m", "m3", "s", "1", "Pa", "m s-1", "kg m-3", "kg", "J", "N s", "kg m s-1", "s-1"}


@pytest.fixture(params=measurements.names())
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@cache
def state_of(kind: type, state: str, *, in_order: bool = True) -> Any:
    """A state for all measurements of its kind, of which each asks it for the same walls and masses."""
    return states()[kind][state]() if in_order else reordered(state_of(kind, state))


@cache
def reading_of(name: str, state: str) -> Reading:
    return read(name, state_of(looks_at(name), state))


def readings(name: str) -> Iterator[tuple[str, Reading]]:
    """What a measurement reads off each state of its kind."""
    for state in states()[looks_at(name)]:
        yield state, reading_of(name, state)


def test_measurement__states_what_it_is(name: str) -> None:
    measurement = measurements.load(name)
    assert measurement.unit in UNITS
    assert len(measurement.meaning) > 10
    assert measurement.version >= 1
    assert (looks_at(name) is History) == bool(measurement.follows)
    assert not any(measurements.load(other).follows for other in measurement.follows)


def test_measurement__has_a_value_with_its_uncertainty_or_a_flag(name: str) -> None:
    for state, reading in readings(name):
        assert math.isfinite(reading.value) or reading.flags, state
        if math.isfinite(reading.value):
            assert all(math.isfinite(part) and part >= 0.0 for part in reading.parts.values()), state
            # A nominal length is read off no grid.
            if measurements.load(name).unit == "m" and not name.startswith("fragment_size"):
                assert reading.parts["resolution"] == RESOLUTION_IN_CELLS * CELL, state


@pytest.mark.claim("mend-again", "no-error-of-zero")
def test_uncertainty__is_no_zero_and_where_unknown_says_so(name: str) -> None:
    """No measurement states an uncertainty of 0: where nothing tells an error there is none, and a flag says so."""
    measurement = measurements.load(name)
    for state, reading in readings(name):
        if math.isfinite(reading.value):
            size, flags = measurement.uncertainty_by(reading.parts)
            assert size is None or size > 0.0, state
            is_told = measurement.is_outcome or measurement.mesh_determined
            assert flags == ((ERROR_UNKNOWN,) if size is None and not is_told else ()), state


def test_measurement__does_not_depend_on_the_order_of_particles(name: str) -> None:
    kind = looks_at(name)
    if kind is History:
        return
    for state, first in readings(name):
        second = read(name, state_of(kind, state, in_order=False))
        assert first.flags == second.flags, state
        # Sums run in another order.
        assert np.isclose(first.value, second.value, rtol=1e-10, atol=1e-10 * CELL, equal_nan=True), state
