"""The loop: what it refuses, what ends it, what it books, and the steps that it takes."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from solver.errors import ProblemError, UnphysicalState
from solver.problem import Body, Face, Problem, Scheme
from solver.registry import entries
from solver.simulation import SORT_INTERVAL, Simulation, simulate, start
from solver.state import NEW_X, NEW_Z, ROWS, Particles, Snapshot, reordered
from solver.step import Partition
from tests.solver.bodies import (
    ABOUT_AXIS,
    DENSITY,
    FREE,
    OPEN,
    SPACING,
    block,
    box,
    real_copper,
    two_blocks,
)

# A uniform body that leaves the grid changes nothing but who holds the numbers; what is left is the round-off of sums.
ROUND_OFF = 1e-12
KINDS = ("axisymmetric", "cartesian")
SHAPES = {name: entry.record() for name, entry in entries("solver.shapes", "SHAPE").items()}


def flying_out(kind: str, speed: float = 3000.0) -> Problem:
    """A block that leaves through the free upper face while another stands still."""
    flat = kind == "axisymmetric"
    geometry = box(6, 10) if flat else box(6, 6, 10)
    low, high = ((1.0,), (4.0,)) if flat else ((1.0, 2.0), (4.0, 4.0))
    velocity = (0.0, speed, 0.0) if flat else (0.0, 0.0, speed)
    bodies = (
        block(geometry, (*low, 1.0), (*high, 2.0), name="stays"),
        block(geometry, (*low, 6.0), (*high, 9.0), velocity=velocity, name="goes"),
    )
    return Problem(geometry, bodies, ABOUT_AXIS if flat else OPEN, end_time=3e-6)


# Its memory


@pytest.mark.parametrize("order", [[4, 0, 3, 1, 2], [3, 1], []])
def test_reordered__takes_columns_in_the_memory_of_the_table(order: list[int]) -> None:
    table = np.arange(ROWS * 5.0).reshape(ROWS, 5)
    expected = table[:, order]
    found = reordered(table, np.array(order, np.int64))
    assert np.array_equal(found, expected)
    assert found.flags.c_contiguous
    assert np.shares_memory(found, table) or not order


def test_simulation__has_one_table_whose_memory_stays_when_particles_leave() -> None:
    simulation = start(flying_out("axisymmetric"), threads=1)
    table, count = simulation.table, simulation.table.shape[1]
    while simulation.table.shape[1] == count:
        simulation.advance()
    assert np.shares_memory(simulation.table, table)
    for name in ("position", "velocity", "deviator", "mass", "temperature"):
        assert np.shares_memory(getattr(simulation.particles, name), table), name


# What it refuses


def test_start__refuses_a_body_outside_the_grid() -> None:
    geometry = box(4, 4, 4)
    outside = block(geometry, (1.0, 1.0, 2.0), (3.0, 3.0, 5.0), name="tall")
    with pytest.raises(ProblemError, match=r"'tall' reaches 0\.00475 m on axis 2.*enlarge"):
        start(Problem(geometry, (outside,), OPEN, end_time=1e-6))


def test_problem__refuses_an_empty_body_and_names_it() -> None:
    geometry = box(4, 4, 4)
    full = block(geometry, (1.0, 1.0, 1.0), (2.0, 2.0, 2.0))
    empty = replace(full, name="ghost", position=np.zeros((0, 3)), mass=np.zeros(0))
    with pytest.raises(ProblemError, match="ghost"):
        Problem(geometry, (full, empty), OPEN, end_time=1e-6)


def test_problem__refuses_to_have_no_body() -> None:
    with pytest.raises(ProblemError, match="without particles"):
        Problem(box(4, 4, 4), (), OPEN, end_time=1e-6)


@pytest.mark.parametrize("courant", [0.0, -0.4, 1.1, float("nan")])
def test_problem__refuses_a_courant_number_outside_its_range(courant: float) -> None:
    with pytest.raises(ProblemError, match=f"courant = {courant}"):
        two_blocks("axisymmetric", courant=courant)


@pytest.mark.parametrize("end_time", [0.0, -1e-6, float("nan")])
def test_problem__refuses_an_end_before_the_beginning(end_time: float) -> None:
    with pytest.raises(ProblemError, match="end_time"):
        two_blocks("axisymmetric", end_time=end_time)


# Unphysical states


def spoiled(
    change: Callable[[Particles, int], None],
    *,
    number: int = 11,
    scheme: Scheme = Scheme.MUSL,
) -> UnphysicalState:
    """What ends a run after five sound steps and a change to one particle, known by its permanent number."""
    simulation = start(two_blocks("axisymmetric", scheme=scheme), threads=1)
    for _ in range(5):
        simulation.advance()
    place = int(np.flatnonzero(simulation.particles.number == number)[0])
    change(simulation.particles, place)
    with pytest.raises(UnphysicalState) as caught:
        take(simulation, steps=3)
    assert caught.value.time == simulation.time
    assert caught.value.step == simulation.step
    return caught.value


def take(simulation: Simulation, *, steps: int) -> None:
    for _ in range(steps):
        simulation.advance()


def set_field(name: str, value: float) -> Callable[[Particles, int], None]:
    def change(particles: Particles, place: int) -> None:
        getattr(particles, name)[place] = value

    return change


def test_nan__names_particle_body_time_quantity_and_value() -> None:
    error = spoiled(set_field("energy", np.nan))
    assert (error.particle, error.body, error.step) == (11, "flyer", 6)
    assert error.quantity == "specific internal energy"
    assert np.isnan(error.value)
    assert str(error).startswith("specific internal energy = nan at particle 11 of 'flyer', t = ")


def test_huge_speed__names_particle_body_time_quantity_and_value() -> None:
    error = spoiled(set_field("velocity", 1e5))
    assert (error.particle, error.body, error.quantity) == (11, "flyer", "speed")
    assert error.value > 5e4


def test_density__beyond_all_compression_names_its_particle() -> None:
    error = spoiled(set_field("density", 9.0 * DENSITY))
    assert (error.particle, error.body, error.quantity) == (11, "flyer", "density")
    assert error.value == pytest.approx(9.0 * DENSITY, rel=0.1)


def test_density__next_to_nothing_ends_the_run() -> None:
    """A volume grown by 1e9 spoils its neighbours within the same step; the first of them is named."""
    assert spoiled(set_field("density", 0.5e-9 * DENSITY)).quantity == "density"


@pytest.mark.parametrize("scheme", list(Scheme))
@pytest.mark.parametrize(
    "field",
    ["velocity", "density", "energy", "pressure", "viscosity", "deviator", "plastic_strain", "temperature"],
)  # fmt: skip
def test_nan__in_any_field_ends_the_run_within_three_steps(field: str, scheme: Scheme) -> None:
    spoiled(set_field(field, np.nan), scheme=scheme)


def test_place_that_is_no_number__is_found_before_usf_sorts_by_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    simulation = start(two_blocks("axisymmetric", scheme=Scheme.USF), threads=1)
    move = simulation.stepper._move

    def astray(partition: Partition, dt: float, impulse: np.ndarray) -> tuple[float, float]:
        taken = move(partition, dt, impulse)
        partition.table[NEW_X : NEW_Z + 1, 7] = np.nan
        return taken

    monkeypatch.setattr(simulation.stepper, "_move", astray)
    with pytest.raises(UnphysicalState, match="position = nan"):
        simulation.advance()


@pytest.mark.parametrize(
    ("rate", "share", "sound"), [(1e6, 1.0 + 1e-6, True), (-1e6, 1.0 - 1e-6, False)]
)
def test_limit__is_that_of_the_energy_which_the_particle_keeps(
    rate: float, share: float, sound: bool
) -> None:
    """With USF the energy to come, on which expansion and compression have already worked."""
    geometry = box(6, 6, 6)
    body = block(geometry, (2.0, 2.0, 2.0), (4.0, 4.0, 4.0))
    body = replace(body, velocity=rate * (body.position - 3.0 * SPACING))
    simulation = start(
        Problem(geometry, (body,), OPEN, end_time=1e-6, scheme=Scheme.USF, fixed_dt=1e-9), threads=1
    )
    simulation.particles.energy[7] = share * simulation.limits.energy
    if sound:
        simulation.advance()
    else:
        with pytest.raises(UnphysicalState, match="specific internal energy"):
            simulation.advance()


def test_unphysical_state__finds_the_permanent_number_after_the_arrays_were_reordered() -> None:
    simulation = start(two_blocks("axisymmetric"), threads=1)
    for _ in range(SORT_INTERVAL + 1):
        simulation.advance()
    place = int(np.flatnonzero(simulation.particles.number == 23)[0])
    assert place != 23
    simulation.particles.energy[place] = np.nan
    with pytest.raises(UnphysicalState) as caught:
        simulation.advance()
    assert caught.value.particle == 23


def test_simulate__raises_what_a_step_finds() -> None:
    """Two blocks that meet at 2 km/s with steps far beyond the stable one."""
    with pytest.raises(UnphysicalState):
        simulate(two_blocks("axisymmetric", fixed_dt=5e-7, end_time=1e-4))


# What leaves the grid


@pytest.mark.parametrize("kind", KINDS)
def test_outflow__closes_mass_momentum_and_energy(kind: str) -> None:
    problem = flying_out(kind)
    outcome = simulate(problem, interval=0.2e-6)
    goes = problem.bodies[1]
    share = goes.mass.sum() / sum(body.mass.sum() for body in problem.bodies)
    assert outcome.audit.outflow_mass == pytest.approx(share, rel=ROUND_OFF)
    assert outcome.audit.outflow_energy == pytest.approx(1.0, rel=ROUND_OFF)
    for audit in outcome.history:
        assert audit.mass_error <= ROUND_OFF
        assert audit.momentum_error <= ROUND_OFF
        assert abs(audit.energy_drift) <= ROUND_OFF


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("scheme", list(Scheme))
def test_outflow__is_booked_in_the_step_in_which_it_leaves(
    kind: str, name: str, scheme: Scheme
) -> None:
    """Nothing that has left the grid moves or weighs anything after that step."""
    simulation = start(replace(flying_out(kind), scheme=scheme, shape=SHAPES[name]), threads=1)
    while simulation.time < simulation.problem.end_time:
        simulation.advance()
        particles = simulation.particles
        gone = particles.alive == 0
        assert not particles.mass[gone].any()
        inside = (particles.position - simulation.problem.geometry.lower) / SPACING
        cells = simulation.problem.geometry.cells
        assert ((inside >= 0.0) & (inside < cells) | (cells == 0)).all()
        assert simulation.audit().mass_error <= ROUND_OFF
        assert simulation.audit().momentum_error <= ROUND_OFF
        assert abs(simulation.audit().energy_drift) <= ROUND_OFF
    assert simulation.ledger.particles == simulation.problem.bodies[1].mass.size


@pytest.mark.parametrize("scheme", list(Scheme))
def test_outflow__leaves_what_is_gone_as_it_was(scheme: Scheme) -> None:
    """Until it is dropped it waits in a corner of the grid, and feels nothing of the matter there."""
    geometry = box(6, 10)
    bodies = (
        block(geometry, (0.0, 0.0), (3.0, 2.0), name="corner"),
        block(geometry, (1.0, 7.5), (4.0, 9.9), velocity=(0.0, 3000.0, 0.0), name="goes"),
    )
    problem = Problem(geometry, bodies, ABOUT_AXIS, end_time=1.0, scheme=scheme)
    simulation = start(problem, threads=1)
    simulation.particles.pressure[simulation.body == 0] = 1e9
    seen = 0
    for _ in range(SORT_INTERVAL - 1):
        gone = simulation.particles.alive == 0
        before = [field[gone].copy() for field in simulation.particles]
        simulation.advance()
        for one, field in zip(before, simulation.particles, strict=True):
            assert np.array_equal(field[gone], one)
        seen += int(gone.any())
    assert seen > 5


@pytest.mark.parametrize("kind", KINDS)
def test_outflow__leaves_body_by_layer(kind: str) -> None:
    """Half way out, half of the mass is ledger, and no particle is lost or counted twice."""
    simulation = start(flying_out(kind), threads=1)
    recorded = []
    count = simulation.particles.mass.size
    while simulation.time < 3e-6:
        simulation.advance()
        recorded.append(simulation.ledger.particles)
        assert int(simulation.particles.alive.sum()) + recorded[-1] in (
            count,
            simulation.particles.mass.size + recorded[-1],
        )
    assert recorded == sorted(recorded)
    assert len(set(recorded)) == 7  # nothing, then each of the six layers
    assert simulation.ledger.particles == simulation.problem.bodies[1].mass.size


def test_outflow__of_everything_is_an_error_with_a_cure() -> None:
    problem = flying_out("axisymmetric")
    with pytest.raises(ProblemError, match="every particle has left the grid"):
        simulate(replace(problem, bodies=problem.bodies[1:]))


def test_outflow__counts_in_the_final_snapshot_as_not_living() -> None:
    outcome = simulate(flying_out("cartesian"))
    particles = outcome.snapshot.particles
    living = particles.alive == 1
    assert (outcome.snapshot.body[living] == 0).all()
    assert int(living.sum()) == 1 * 3 * 2 * 8


# Steps and observations


def steps_of(simulation: Simulation, end_time: float) -> list[float]:
    steps = []
    while simulation.time < end_time:
        before = simulation.time
        simulation.advance()
        steps.append(simulation.time - before)
    return steps


def test_fixed_dt__is_used_exactly() -> None:
    problem = two_blocks("axisymmetric", fixed_dt=1e-8, end_time=1e-6)
    simulation = start(problem, threads=1)
    for _ in range(20):
        assert simulation.dt == 1e-8
        simulation.advance()
    outcome = simulate(problem)
    assert outcome.smallest_step == 1e-8
    assert outcome.snapshot.step in (100, 101)  # a hundred additions of 1e-8 may end just short


def test_observer__does_not_cut_the_steps() -> None:
    """A run that is looked at in every step takes the same steps, to the bit, as one that nobody looks at."""
    problem = two_blocks("axisymmetric")
    seen: list[float] = []

    def look(snapshot: Snapshot) -> None:
        seen.append(snapshot.time)

    often, never = simulate(problem, look, interval=1e-10), simulate(problem)
    assert len(seen) == often.snapshot.step + 1
    assert often.snapshot.time == never.snapshot.time
    assert often.snapshot.step == never.snapshot.step
    for name in Particles._fields:
        one, other = (getattr(outcome.snapshot.particles, name) for outcome in (often, never))
        assert np.array_equal(one, other), name


def test_observer__sees_the_start_the_first_step_after_each_interval_and_the_end() -> None:
    problem = two_blocks("axisymmetric")
    interval = 0.25e-6
    seen: list[float] = []

    def look(snapshot: Snapshot) -> None:
        seen.append(snapshot.time)

    outcome = simulate(problem, look, interval=interval)
    assert seen[0] == 0.0
    assert seen[-1] == outcome.snapshot.time >= problem.end_time
    assert len(seen) == 5
    steps = steps_of(start(problem, threads=1), problem.end_time)
    for number, time in enumerate(seen):
        assert number * interval <= time < number * interval + max(steps)


def test_observer__stops_the_run_with_its_word() -> None:
    def enough(snapshot: Snapshot) -> str | None:
        return "seen enough" if snapshot.time > 0.4e-6 else None

    outcome = simulate(two_blocks("axisymmetric"), enough, interval=0.1e-6)
    assert outcome.stop == "seen enough"
    assert 0.4e-6 < outcome.snapshot.time < 0.6e-6
    assert outcome.audit.time == outcome.snapshot.time


def test_observer__may_stop_before_the_first_step() -> None:
    outcome = simulate(two_blocks("axisymmetric"), lambda snapshot: "no")
    assert (outcome.stop, outcome.snapshot.step) == ("no", 0)


def test_simulate__ends_at_its_end_time() -> None:
    outcome = simulate(two_blocks("axisymmetric", end_time=0.3e-6))
    assert outcome.stop == "end_time"
    assert outcome.snapshot.time >= 0.3e-6
    assert outcome.snapshot.time - outcome.smallest_step < 0.3e-6 * 1.1


def test_simulate__keeps_an_audit_of_each_observation() -> None:
    outcome = simulate(two_blocks("axisymmetric"), interval=0.25e-6)
    assert len(outcome.history) == 5
    assert outcome.history[-1] is outcome.audit
    assert outcome.history[0].energy_drift == 0.0


@pytest.mark.parametrize("kind", KINDS)
def test_simulate__keeps_mass_momentum_and_energy_to_round_off_in_an_impact(kind: str) -> None:
    """Shock, plastic flow, cut tension and outflow: the internal energy takes what the nodal forces do."""
    outcome = simulate(two_blocks(kind, end_time=4e-6))
    audit = outcome.audit
    assert outcome.counters.tension_floors > 0
    assert audit.mass_error <= ROUND_OFF
    assert audit.momentum_error <= ROUND_OFF
    assert abs(audit.energy_drift) <= ROUND_OFF


def test_counters__notice_matter_beyond_the_range_of_its_equation_of_state() -> None:
    simulation = start(two_blocks("axisymmetric"), threads=1)
    simulation.advance()
    assert simulation.counters.beyond_hugoniot == 0
    eos = real_copper().eos
    simulation.particles.density[3:5] = 1.1 * DENSITY * (1.0 + eos.mu_tangent)
    simulation.advance()
    assert simulation.counters.beyond_hugoniot == 2


def test_counters__notice_cut_tension_and_temperatures_below_zero() -> None:
    simulation = start(two_blocks("axisymmetric"), threads=1)
    simulation.advance()
    assert (simulation.counters.tension_floors, simulation.counters.below_zero_kelvin) == (0, 0)
    simulation.particles.density[3] = 0.9 * DENSITY
    simulation.particles.energy[10:12] = -3e5
    simulation.advance()
    assert simulation.counters.tension_floors >= 1
    assert simulation.counters.below_zero_kelvin == 2
    assert simulation.particles.temperature[10:12].tolist() == [0.0, 0.0]


def test_simulation__leaves_the_bodies_of_the_problem_as_they_were() -> None:
    problem = two_blocks("axisymmetric")
    before = [body.position.copy() for body in problem.bodies]
    simulate(problem)
    assert all(
        np.array_equal(body.position, old) for body, old in zip(problem.bodies, before, strict=True)
    )


def test_simulation__is_repeatable_to_the_bit() -> None:
    one, other = (simulate(two_blocks("cartesian", end_time=0.5e-6)) for _ in range(2))
    for name in Particles._fields:
        assert np.array_equal(
            getattr(one.snapshot.particles, name), getattr(other.snapshot.particles, name)
        )


def test_body__of_another_matter_keeps_its_own_laws() -> None:
    """Two bodies of different types side by side: each is updated by its own kernel."""
    geometry = box(8, 8)
    bodies: tuple[Body, ...] = (
        block(geometry, (0.0, 1.0), (3.0, 3.0), velocity=(0.0, 500.0, 0.0), name="hard"),
        block(geometry, (0.0, 3.0), (3.0, 6.0), name="soft", matter=real_copper()),
    )
    faces = ((Face.SYMMETRIC, Face.FREE), FREE, FREE)
    outcome = simulate(Problem(geometry, bodies, faces, end_time=0.5e-6))
    strain = outcome.snapshot.particles.plastic_strain
    assert strain[outcome.snapshot.body == 0].max() == 0.0
    assert strain[outcome.snapshot.body == 1].max() > 0.01


# Velocities that differ from particle to particle


def test_body__with_one_velocity_for_each_particle_moves_as_with_one_for_all() -> None:
    """The same numbers in another form: the same first step, the same limits, the same bits."""
    problem = two_blocks("axisymmetric")
    flyer, plate = problem.bodies
    each = np.tile(flyer.velocity, (flyer.mass.size, 1))
    other = replace(problem, bodies=(replace(flyer, velocity=each), plate))
    one, two = (simulate(which, threads=1).snapshot.particles for which in (problem, other))
    assert all(a.tobytes() == b.tobytes() for a, b in zip(one, two, strict=True))


def test_first_step__is_that_of_the_fastest_particle() -> None:
    problem = two_blocks("axisymmetric")
    flyer, plate = problem.bodies
    each = np.zeros((flyer.mass.size, 3))
    each[3] = (0.0, *flyer.velocity[1:])
    slow = replace(problem, bodies=(replace(flyer, velocity=0.0 * flyer.velocity), plate))
    mixed = replace(problem, bodies=(replace(flyer, velocity=each), plate))
    assert start(mixed).dt == start(problem).dt
    assert start(mixed).dt < start(slow).dt
