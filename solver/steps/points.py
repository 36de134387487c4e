"""The stress update of one body's material points, as each method calls it: kernel, tally and faults.

The points may be particles on a grid, particles among neighbours, or the integration points of elements: where their
velocity gradients come from, their space says (``space.py``). Body by body, because the laws are chosen by the types in
its ``Matter``, and eight at a time.
"""

from typing import NamedTuple

import numpy as np

from solver import state
from solver.jit import Bound, device, kernel
from solver.matter.eos import below_range, burning, outside_range, reference_density
from solver.matter.failure import weakens
from solver.matter.laws import Matter
from solver.matter.strength import stored_part
from solver.matter.stress import PointState, advance, signal_speed
from solver.matter.tension import linking
from solver.matter.tensor import contract
from solver.problem import ArtificialViscosity, Problem
from solver.problem.geometry import Geometry, dimensions, hoop_factor, unpacked
from solver.state import Particles
from solver.steps.space import (
    PACK,
    Gridless,
    deviators_of,
    find_nodes,
    gather,
    new_pack,
    opened,
    own_length,
    velocity_gradient,
)
from solver.vectors import (
    LANES,
    absolute,
    anywhere,
    bare,
    counted,
    finite,
    first_lanes,
    largest,
    load,
    maximum,
    spread,
    sqrt,
    store,
    where,
)


class StateLimits(NamedTuple):
    """Limits beyond which a state is unphysical."""

    densest: float  # times the reference density
    thinnest: float  # times the reference density
    energy: float  # J/kg, either sign
    speed: float  # m/s


class Tally(NamedTuple):
    """Largest values and counts over the particles of a step; kernels write one row for each body in each share."""

    signal: float  # largest signal speed, m/s
    convected: float  # largest signal speed + particle speed, m/s
    speed: float  # largest particle speed, m/s
    volume_rate: float  # largest |tr D|, 1/s
    tension_floors: float  # particles whose pressure was lifted to the tensile floor
    beyond_hugoniot: float  # particles denser than the range of the equation of state
    below_expansion: float  # particles thinner than the range of the equation of state
    below_zero_kelvin: float  # particles whose temperature was lifted to 0 K
    molten: float  # particles whose homologous temperature was held at 1
    sound_floors: float  # particles whose signal speed rests on the floor of the sound speed
    unstable: float  # particles whose negative c^2 counted as zero for the viscosity
    failed: float  # particles that failed in this step
    outside: float  # particles now outside the grid, for ``crossing.cross_faces``
    fault: float  # 1 where a state is unphysical
    culprit: float  # the first particle of the first eight among which one is


MAXIMA = 4  # of the columns, from the first on; the counts follow
OUTSIDE, FAULT, CULPRIT = map(Tally._fields.index, ("outside", "fault", "culprit"))


@kernel
def summarise(tallies, summary):
    """The tally of all rows, into ``summary`` (columns,): the largest speeds and rates, all counts, the first fault."""
    summary[:] = 0.0
    for row in range(tallies.shape[0]):
        for column in range(MAXIMA):
            summary[column] = max(summary[column], tallies[row, column])
        for column in range(MAXIMA, OUTSIDE + 1):
            summary[column] += tallies[row, column]
        if tallies[row, FAULT] > 0.0 and summary[FAULT] == 0.0:
            summary[FAULT], summary[CULPRIT] = 1.0, tallies[row, CULPRIT]


@kernel
def update_particles(
    geometry,
    shape,
    pack,
    matter,
    stress_rate,
    viscosity,
    limits,
    table,
    begin,
    end,
    nodes,
    tallies,
    row,
    time,
    dt,
    whole_work,
    heats,
):
    """Advance stress, density, energy and position of the particles begin..end of one body.

    ``nodes`` is the table of the mapped velocities; the tally goes to one row of ``tallies``. ``whole_work`` 1 stores
    the energy with the new stress' half of the work of this velocity gradient, 0 leaves that half to the forces that
    follow. ``time`` is that of the new stress. With ``heats`` 1 the rows SHEARED to DAMPED take the parts of the work.
    """
    geometry = unpacked(geometry)
    pack = opened(pack)
    table, nodes = bare(table), bare(nodes)
    none = spread(0.0)
    signal = convected = moving = fastest = none
    floors = beyond = below = cold = molten = slow = unstable = failed = outside = 0
    fault, culprit = 0.0, 0.0
    inverse = 1.0 / geometry.spacing
    for start in range(begin, end, PACK):
        stop = min(start + PACK, end)
        find_nodes(geometry, shape, table, start, stop, pack)
        for k in range(stop - start):
            gather(geometry, shape, k, pack, nodes, pack.lines)
        for p in range(start, stop, LANES):
            within = first_lanes(stop - p)
            lanes = within & (load(table, state.MASS, p, within) > 0.0)  # what has left the grid has none
            hoop = hoop_factor(geometry, load(table, state.X, p, lanes))
            gradient = velocity_gradient(geometry, pack.lines, p - start, hoop)
            old = PointState(
                load(table, state.DENSITY, p, lanes),
                load(table, state.ENERGY, p, lanes),
                load(table, state.PRESSURE, p, lanes),
                load(table, state.VISCOSITY, p, lanes),
                deviators_of(table, p, lanes),
                load(table, state.STRAIN, p, lanes),
                load(table, state.KELVIN, p, lanes),
                load(table, state.DAMAGE, p, lanes),
                load(table, state.HARDENED, p, lanes) if weakens(matter.failure) else none,
                load(table, state.STORED, p, lanes) if stored_part(matter.strength) > 0.0 else none,
                load(table, state.PARTED, p, lanes) if linking(matter.tension) < 1.0 else none,
                load(table, state.GROWN, p, lanes) if linking(matter.tension) < 1.0 else none,
            )
            local = Matter(burning(matter.eos, table, p, lanes, time, geometry.spacing), *matter[1:])
            length = own_length(geometry, p, lanes)
            new, present, acts = advance(local, viscosity, length, dt, gradient, old, stress_rate)
            store(table, state.DENSITY, p, new.density, lanes)
            energy = present if whole_work else new.energy
            store(table, state.ENERGY, p, energy, lanes)
            store(table, state.PRESSURE, p, new.pressure, lanes)
            store(table, state.VISCOSITY, p, new.viscosity, lanes)
            store(table, state.S11, p, new.deviator[0], lanes)
            store(table, state.S22, p, new.deviator[1], lanes)
            store(table, state.S33, p, new.deviator[2], lanes)
            store(table, state.S12, p, new.deviator[3], lanes)
            store(table, state.S23, p, new.deviator[4], lanes)
            store(table, state.S31, p, new.deviator[5], lanes)
            store(table, state.STRAIN, p, new.plastic_strain, lanes)
            store(table, state.KELVIN, p, maximum(new.temperature, 0.0), lanes)
            store(table, state.DAMAGE, p, new.damage, lanes)
            if linking(matter.tension) < 1.0:
                store(table, state.PARTED, p, new.parted, lanes)
                store(table, state.GROWN, p, new.grown, lanes)
            if weakens(matter.failure):
                store(table, state.HARDENED, p, new.hardened, lanes)
            if stored_part(matter.strength) > 0.0:
                store(table, state.STORED, p, new.stored, lanes)
            if heats:
                store(table, state.SHEARED, p, load(table, state.SHEARED, p, lanes) + acts.sheared, lanes)
                store(table, state.PULLED, p, load(table, state.PULLED, p, lanes) + acts.pulled, lanes)
                store(table, state.DAMPED, p, load(table, state.DAMPED, p, lanes) + acts.damped, lanes)
            place = none
            past = lanes & (none > 0.0)
            for axis in range(3):
                coordinate = load(table, state.NEW_X + axis, p, lanes)
                store(table, state.X + axis, p, coordinate, lanes)
                place = place + coordinate
                if axis < dimensions(geometry):
                    cells = (coordinate - geometry.lower[axis]) * inverse
                    past = past | (cells < 0.0) | (cells >= geometry.cells[axis])
            vx, vy = load(table, state.VX, p, lanes), load(table, state.VY, p, lanes)
            vz = load(table, state.VZ, p, lanes)
            speed = sqrt(vx * vx + vy * vy + vz * vz)
            rate = gradient[0][0] + gradient[1][1] + gradient[2][2]
            own, floored = signal_speed(local, viscosity, length, rate, new)
            own = own * (geometry.spacing / length)  # that takes as long through a cell of the grid
            signal = maximum(signal, where(lanes, own, 0.0))
            convected = maximum(convected, where(lanes, speed + own, 0.0))
            moving = maximum(moving, where(lanes, speed, 0.0))
            fastest = maximum(fastest, where(lanes, absolute(rate), 0.0))
            floors += counted(lanes & acts.tension_floor)
            molten += counted(lanes & acts.molten)
            unstable += counted(lanes & acts.unstable)
            slow += counted(lanes & floored)
            beyond += counted(lanes & outside_range(matter.eos, new.density))
            below += counted(lanes & below_range(matter.eos, new.density))
            cold += counted(lanes & (new.temperature < 0.0))
            broken = (new.damage >= 1.0) & ~(old.damage >= 1.0)
            failed += counted(lanes & broken)
            outside += counted(lanes & past)
            physical = is_physical(matter, limits, new, energy, speed, place)
            if fault == 0.0 and anywhere(lanes & ~physical):
                fault, culprit = 1.0, float(p)
    tally = tallies[row]
    tally[0], tally[1], tally[2] = largest(signal), largest(convected), largest(moving)
    tally[3], tally[4], tally[5] = largest(fastest), floors, beyond
    tally[6], tally[7], tally[8], tally[9] = below, cold, molten, slow
    tally[10], tally[11], tally[OUTSIDE] = unstable, failed, outside
    tally[FAULT], tally[CULPRIT] = fault, culprit


@device
def is_physical(matter, limits, point, energy, speed, place):
    """Whether a state, with the energy that is stored, is within its limits; NaN fails the comparisons."""
    ratio = point.density * (1.0 / reference_density(matter.eos))
    stress = point.pressure + point.viscosity + contract(point.deviator, point.deviator)
    stress = stress + point.plastic_strain + point.temperature
    return (
        (ratio > limits.thinnest)
        & (ratio < limits.densest)
        & (absolute(energy) < limits.energy)
        & finite(stress)
        & (speed < limits.speed)
        & finite(place)
    )


class PointUpdate:
    """The update of all points of a problem's bodies, share by share: kernels, scratch and tallies."""

    def __init__(self, problem: Problem, limits: StateLimits, shares: int):
        self.problem, self.limits = problem, limits
        self.packs = [new_pack() for _ in range(shares)]
        self.tallies = np.zeros((shares * len(problem.bodies), len(Tally._fields)))
        self.summary = np.zeros(len(Tally._fields))
        self.kernels = [Bound(update_particles) for _ in problem.bodies]
        self.summarise = Bound(summarise)

    def update(
        self,
        space: Geometry | Gridless,
        viscosity: ArtificialViscosity,
        share: int,
        body: int,
        table: np.ndarray,
        span: tuple[int, int],
        gradients: np.ndarray,
        time: float,
        dt: float,
        whole_work: int = 0,
    ) -> None:
        """Take the points of a body in a span of the table to a time; ``gradients`` are lines of a table."""
        problem = self.problem
        laws = problem.bodies[body].matter, problem.stress_rate, viscosity, self.limits
        row = share * len(problem.bodies) + body
        points = table, *span, gradients, self.tallies, row
        heats = int(problem.audits_heat)
        self.kernels[body](space, problem.shape, self.packs[share], *laws, *points, time, dt, whole_work, heats)

    def tally(self) -> Tally:
        """What all shares counted in the last updates."""
        self.summarise(self.tallies, self.summary)
        return Tally(*self.summary.tolist())


def first_fault(
    problem: Problem, limits: StateLimits, particles: Particles, body: np.ndarray, first: int
) -> tuple[int, str, float]:
    """The first unphysical particle of the eight from one on: its index, the quantity and its value."""
    for p in range(first, min(first + LANES, body.size)):
        checks = _checks(problem.bodies[int(body[p])].matter, limits, particles, np.array([p]))
        found = [(quantity, float(values[0])) for quantity, physical, values in checks if not physical[0]]
        if found and particles.mass[p] > 0.0:
            return p, *found[0]
    raise LookupError("none of the eight is unphysical")


def unphysical(problem: Problem, limits: StateLimits, particles: Particles, body: np.ndarray) -> np.ndarray:
    """Indices of all particles that are unphysical, ascending."""
    beyond = np.zeros(body.size, bool)
    for number, made in enumerate(problem.bodies):
        mine = np.flatnonzero((body == number) & (particles.mass > 0.0))
        for _, physical, _ in _checks(made.matter, limits, particles, mine):
            beyond[mine[~physical]] = True
    return np.flatnonzero(beyond)


def _checks(
    matter: Matter, limits: StateLimits, particles: Particles, index: np.ndarray
) -> tuple[tuple[str, np.ndarray, np.ndarray], ...]:
    """Each quantity of some particles that has limits: its name, whether it is within them, and its values."""
    density, energy, pressure = (getattr(particles, name)[index] for name in ("density", "energy", "pressure"))
    ratio = density / reference_density(matter.eos)
    speed = np.linalg.norm(particles.velocity[index], axis=1)
    stress = pressure + particles.viscosity[index] + particles.deviator[index].sum(axis=1)
    stress += particles.plastic_strain[index] + particles.temperature[index]
    place = particles.position[index].sum(axis=1)
    return (
        ("density", (limits.thinnest < ratio) & (ratio < limits.densest), density),
        ("specific internal energy", np.abs(energy) < limits.energy, energy),
        ("pressure", np.isfinite(stress), pressure),
        ("speed", speed < limits.speed, speed),
        ("position", np.isfinite(place), place),
    )
