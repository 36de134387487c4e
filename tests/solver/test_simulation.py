"""The loop: what it refuses, what ends it, what it accounts for, and the steps that it takes."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest

from solver.errors import ProblemError, UnphysicalState
from solver.problem import Problem, Scheme, Traction
from solver.simulation import Simulation, simulate, start
from solver.state import Snapshot
from tests.solver.bodies import (
    DENSITY,
    OPEN,
    ROUND_OFF,
    SPACING,
    after,
    assert_balanced,
    assert_same_bits,
    block,
    box,
    each_kind,
    each_shape,
    leaving,
    two_blocks,
)

each_scheme = pytest.mark.parametrize("scheme", list(Scheme))
ELASTIC = block(box(4, 4), (1.0, 1.0), (3.0, 3.0))


# What it refuses


def test_start__refuses_a_body_outside_the_grid() -> None:
    geometry = box(4, 4, 4)
    outside = block(geometry, (1.0, 1.0, 2.0), (3.0, 3.0, 5.0), name="tall")
    with pytest.raises(ProblemError, match=r"'tall' reaches 0\.00475 m on axis 2.*enlarge"):
        start(Problem(geometry, (outside,), OPEN, end_time=1e-6))


@pytest.mark.parametrize(
    ("changes", "error"),
    [
        ({"bodies": ()}, "without particles"),
        ({"bodies": (replace(ELASTIC, name="ghost", position=np.zeros((0, 3)), mass=np.zeros(0)), ELASTIC)}, "ghost"),
        *(({"courant": value}, f"courant = {value}") for value in (0.0, -0.4, 1.1, float("nan"))),
        *(({"end_time": value}, "end_time") for value in (0.0, -1e-6, float("nan"))),
        *(
            ({"tractions": (Traction(0, 0, 1, np.array(time), np.array(pressure)),)}, error)
            for time, pressure, error in (
                ([1.0], [1.0], "at least two"),
                ([1.0, 2.0], [1.0], "as many"),
                ([2.0, 1.0], [1.0, 1.0], "ascend"),
                ([1.0, 2.0], [1.0, np.inf], "finite"),
            )
        ),
    ],
)
def test_problem__refuses_what_cannot_be_computed(changes: Mapping[str, Any], error: str) -> None:
    with pytest.raises(ProblemError, match=error):
        replace(two_blocks("axisymmetric"), **changes)


# Unphysical states


def error_after(name: str, value: float, **changes: Any) -> UnphysicalState:
    """The error that ends a run within three steps after a change to particle 11 of the first body."""
    simulation = after(two_blocks("axisymmetric", **changes), 5)
    place = int(np.flatnonzero(simulation.particles.number == 11)[0])
    getattr(simulation.particles, name)[place] = value
    with pytest.raises(UnphysicalState) as caught:
        _take_three(simulation)
    assert (caught.value.time, caught.value.step) == (simulation.time, simulation.step)
    return caught.value


def _take_three(simulation: Simulation) -> None:
    for _ in range(3):
        simulation.advance()


@pytest.mark.parametrize(
    ("name", "value", "quantity", "least"),
    [
        ("energy", np.nan, "specific internal energy", np.nan),
        ("velocity", 1e5, "speed", 5e4),
        ("density", 9.0 * DENSITY, "density", 8.1 * DENSITY),
        ("density", 0.5e-9 * DENSITY, "density", None),  # its volume spoils its neighbours: the first is named
    ],
)
def test_unphysical_state__names_particle_body_time_quantity_and_value(
    name: str, value: float, quantity: str, least: float | None
) -> None:
    error = error_after(name, value)
    if least is None:
        assert error.quantity == quantity
        return
    assert (error.particle, error.body, error.quantity, error.step) == (11, "flyer", quantity, 6)
    assert np.isnan(error.value) if np.isnan(value) else error.value > least
    expected = f"{quantity} = {error.value:g} at particle 11 of 'flyer', t = "
    assert str(error).startswith(expected)


@pytest.mark.claim("speed", "nan-seen")
@each_scheme
@pytest.mark.parametrize(
    "field",
    ["velocity", "density", "energy", "pressure", "viscosity", "deviator", "plastic_strain", "temperature"],
)  # fmt: skip
def test_nan__in_any_field_ends_the_run_within_three_steps(field: str, scheme: Scheme) -> None:
    """A NaN in any field ends the run within three steps."""
    error_after(field, np.nan, scheme=scheme)


# What leaves the grid


@each_kind
@each_shape
@each_scheme
def test_outflow__is_in_the_ledger_from_the_step_in_which_it_leaves(kind: str, shape: Any, scheme: Scheme) -> None:
    """Layer by layer; nothing that has left the grid weighs anything after that step."""
    simulation = start(leaving(kind, scheme=scheme, shape=shape), threads=1)
    geometry = simulation.problem.geometry
    goes, recorded = simulation.problem.bodies[1], set()
    while simulation.time < simulation.problem.end_time:
        simulation.advance()
        particles, audit = simulation.particles, simulation.audit()
        assert not particles.mass[particles.alive == 0].any()
        inside = (particles.position - geometry.lower) / SPACING
        assert ((inside >= 0.0) & (inside < geometry.cells) | (geometry.cells == 0)).all()
        assert_balanced(audit)
        recorded.add(simulation.books.ledger.particles)
    assert len(recorded) == 7  # nothing, then each of the six layers
    assert max(recorded) == goes.mass.size
    assert audit.outflow_energy == pytest.approx(1.0, rel=ROUND_OFF)
    share = goes.mass.sum() / sum(body.mass.sum() for body in simulation.problem.bodies)
    assert audit.outflow_mass == pytest.approx(share, rel=ROUND_OFF)
    assert (simulation.body[particles.alive == 1] == 0).all()


def test_outflow__of_everything_is_an_error_with_a_cure() -> None:
    problem = leaving("axisymmetric")
    with pytest.raises(ProblemError, match="every particle has left the grid; enlarge"):
        simulate(replace(problem, bodies=problem.bodies[1:]))


# Steps and observations


def test_observer__sees_the_start_the_first_step_after_each_interval_and_the_end() -> None:
    problem = two_blocks("axisymmetric")
    interval = 0.25e-6
    times: list[float] = []
    outcome = simulate(problem, lambda snapshot: times.append(snapshot.time), interval=interval)
    assert outcome.stop == "end_time"
    assert times[0] == 0.0
    assert times[-1] == outcome.snapshot.time >= problem.end_time
    assert len(times) == len(outcome.history) == 5
    simulation, largest = start(problem, threads=1), 0.0
    while simulation.time < outcome.snapshot.time:
        largest = max(largest, simulation.dt)
        simulation.advance()
    for number, time in enumerate(times):
        assert number * interval <= time < number * interval + largest
    assert outcome.history[-1] is outcome.audit
    assert outcome.history[0].energy_drift == 0.0
    # Observations cut no step: those of a run that nobody looks at are the same, to the bit.
    assert simulation.time == outcome.snapshot.time
    assert simulation.step == outcome.snapshot.step
    assert_same_bits(simulation.particles, outcome.snapshot.particles)


def test_observer__stops_the_run_with_its_reason() -> None:
    def enough(snapshot: Snapshot) -> str | None:
        return "seen enough" if snapshot.time > 0.4e-6 else None

    outcome = simulate(two_blocks("axisymmetric"), enough, interval=0.1e-6)
    assert outcome.stop == "seen enough"
    assert 0.4e-6 < outcome.snapshot.time < 0.6e-6
    assert outcome.audit.time == outcome.snapshot.time
    at_once = simulate(two_blocks("axisymmetric"), lambda snapshot: "no")
    assert (at_once.stop, at_once.snapshot.step) == ("no", 0)


@each_kind
def test_simulate__keeps_mass_momentum_and_energy_to_round_off_in_an_impact(kind: str) -> None:
    """Shock, plastic flow, cut tension and outflow, twice; the bodies of the problem stay as they were."""
    problem = two_blocks(kind, end_time=4e-6)
    bodies = [asdict(body) for body in problem.bodies]
    outcome, again = (simulate(problem) for _ in range(2))
    audit = outcome.audit
    assert outcome.counters.tension_floors > 0
    assert_balanced(audit)
    assert_same_bits(outcome.snapshot.particles, again.snapshot.particles)
    for body, before in zip(problem.bodies, bodies, strict=True):
        assert np.array_equal(body.position, before["position"])
