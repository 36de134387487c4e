"""Every rule of tension only pulls, does not grow with heat, and is paid for by the energy."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from solver.matter.laws import Matter
from solver.matter.melting import LEAST_SPAN, MeltingCurve
from solver.matter.stress import PointState, advance
from solver.matter.tension import TensionEntry, pressure_floor
from solver.problem import ArtificialViscosity
from solver.registry import entries
from tests.solver.bodies import DENSITY, MELT, ROOM, SPACING, real_copper

MEMBERS = entries("solver.matter.tension", "TENSION")
CUTOFF = 1.9e9  # Pa, of copper
COPPER: dict[str, tuple[float, ...]] = {"opening": (CUTOFF,), "recoverable": (CUTOFF,), "unlimited": ()}

DT = 1e-9
UNSTRESSED = (0.0,) * 6
ROUND_OFF = 1e-12


@pytest.fixture(params=list(MEMBERS))
def tension(request: pytest.FixtureRequest) -> Any:
    entry: TensionEntry = MEMBERS[request.param]
    return entry.record(*COPPER[request.param])


def at_rest(temperature: float = ROOM) -> PointState:
    return PointState(DENSITY, 0.0, 0.0, 0.0, UNSTRESSED, 0.0, temperature)


def stretched(matter: Matter, volume: float, old: PointState) -> tuple[PointState, int]:
    """A point whose volume grows by a part in a step, the same in all directions."""
    gradient = np.eye(3) * volume / 3.0 / DT
    point, _, acts = advance(matter, ArtificialViscosity(), SPACING, DT, gradient, old)
    return point, acts.tension_floor


def test_tension__brings_an_example() -> None:
    assert set(COPPER) == set(MEMBERS), "give each rule its copper above"


@given(st.floats(0.0, 1.0))
@pytest.mark.parametrize("name", sorted(MEMBERS))
def test_floor__never_pushes(name: str, homologous: float) -> None:
    assert pressure_floor(MEMBERS[name].record(*COPPER[name]), homologous, 1.0 - homologous) <= 0.0


@given(st.floats(0.0, 1.0), st.floats(0.0, 1.0))
@pytest.mark.parametrize("name", sorted(MEMBERS))
def test_floor__does_not_sink_with_temperature(name: str, one: float, other: float) -> None:
    low, high = sorted((one, other))
    tension = MEMBERS[name].record(*COPPER[name])
    assert pressure_floor(tension, low, 1.0 - low) <= pressure_floor(tension, high, 1.0 - high)


def test_tension__stores_no_pressure_below_its_floor(tension: Any) -> None:
    point, _ = stretched(real_copper()._replace(tension=tension), 0.05, at_rest())
    assert point.pressure >= pressure_floor(tension, 0.0, 1.0)


def test_tension__counts_each_use_of_the_floor(tension: Any) -> None:
    matter = real_copper()._replace(tension=tension)
    gentle, strong = (stretched(matter, volume, at_rest()) for volume in (1e-3, 0.05))
    assert gentle[1] == 0
    assert strong[1] == (strong[0].pressure == pressure_floor(tension, 0.0, 1.0))


@pytest.mark.parametrize("volume", [1e-3, 0.05])
def test_tension__energy_is_the_work_of_the_stored_pressure(tension: Any, volume: float) -> None:
    """The strain update takes half of a step's work, -p tr D dt / 2 rho, of the pressure after the floor."""
    matter = real_copper()._replace(tension=tension)
    pulled, _ = stretched(matter, volume, at_rest())
    again, _ = stretched(matter, volume, pulled)
    work = -0.5 * pulled.pressure * volume / pulled.density
    assert work > 0.0
    assert math.isclose(again.energy - pulled.energy, work, rel_tol=ROUND_OFF)


def test_tension__matter_that_is_pressed_again_carries_load_again(tension: Any) -> None:
    matter = real_copper()._replace(tension=tension)
    point, _ = stretched(matter, 0.05, at_rest())
    for _ in range(2):
        point, floored = stretched(matter, -0.05, point)
    assert floored == 0
    assert point.pressure > CUTOFF


@pytest.mark.parametrize("name", sorted(MEMBERS))
def test_tension__says_whether_molten_matter_bears_it(name: str) -> None:
    melting = MeltingCurve(solidus=MELT, span=LEAST_SPAN if MEMBERS[name].opens else 0.0)
    molten = real_copper()._replace(tension=MEMBERS[name].record(*COPPER[name]), melting=melting)
    point, _ = stretched(molten, 1e-3, at_rest(temperature=MELT + LEAST_SPAN))
    assert (point.pressure < 0.0) == MEMBERS[name].molten
