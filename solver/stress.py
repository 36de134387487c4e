"""Stress update of one body: strain rate, spin, return to the yield surface, pressure, energy, failure, temperature.

Called body by body, because the laws are chosen by the types in its ``Matter``, and eight particles at a time: the
laws are written without ``if``, for a point as for eight of them.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.eos import (
    below_range,
    burning,
    outside_range,
    reference_density,
    reference_sound_speed,
    solve_pressure,
    sound_speed_squared,
    temperature,
)
from solver.failure import PointLoading, floor_until_failure, grown_damage, integrity, weakens
from solver.geometry import PACK, dimensions, gather, hoop_factor, opened, own_length, unpacked, velocity_gradient
from solver.jit import device, kernel
from solver.problem import Matter
from solver.state import (
    DAMAGE,
    DENSITY,
    ENERGY,
    HARDENED,
    KELVIN,
    MASS,
    NEW_X,
    PRESSURE,
    S11,
    S12,
    S22,
    S23,
    S31,
    S33,
    STORED,
    STRAIN,
    VISCOSITY,
    VX,
    VY,
    VZ,
    X,
)
from solver.strength import hardening, melting, rate_and_heat, stiffness, stored_part, under_pressure
from solver.tension import pressure_floor
from solver.tensor import (
    Jaumann,
    added,
    carried,
    contract,
    deviator,
    equivalent_strain,
    equivalent_stress,
    scaled,
    strain_increment,
    volume_ratio,
)
from solver.transfer import find_nodes
from solver.vectors import (
    LANES,
    absolute,
    alike,
    anywhere,
    bare,
    counted,
    finite,
    first_lanes,
    largest,
    load,
    maximum,
    minimum,
    spread,
    sqrt,
    store,
    where,
)

RETURN_TOLERANCE = 1e-12  # distance of the stress from the yield surface, over the trial stress
# Steps of the rule, and what is left at least of an increment that was too long.
NEWTONS, NEWTON_BACK = (40, 1e-9)

# Of c0, in the time step only: an expanded solid has no sound to speak of, and steps without bound would follow.
SOUND_SPEED_FLOOR = 0.2

# Pa, of the equivalent stress in the triaxiality: matter that bears less is a liquid, and the ratio stays finite.
LEAST_STRESS = 1.0

JAUMANN = Jaumann()

# Kinds of unphysical state; the text is what the error says.
QUANTITIES = ("", "density", "specific internal energy", "pressure", "speed", "position")
PHYSICAL, BAD_DENSITY, BAD_ENERGY, BAD_PRESSURE, BAD_SPEED, BAD_POSITION = range(6)


class Limits(NamedTuple):
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
    outside: float  # particles now outside the grid, for ``faces.cross_faces``
    fault: float  # 1 where a state is unphysical
    culprit: float  # the first particle of the first eight among which one is


MAXIMA = 4  # of the columns, from the first on; the counts follow
OUTSIDE, FAULT, CULPRIT = map(Tally._fields.index, ("outside", "fault", "culprit"))


class PointState(NamedTuple):
    """The state of one particle, or of eight, that the laws act on."""

    density: float
    energy: float
    pressure: float
    viscosity: float
    deviator: tuple[float, float, float, float, float, float]
    plastic_strain: float
    temperature: float
    damage: float = 0.0
    # Plastic strain, each increment times the integrity of its time, where damage weakens: r of the hardening.
    hardened: float = 0.0
    stored: float = 0.0  # plastic work that did not become heat, J/kg


class Acts(NamedTuple):
    """Which safeguards acted on a point in a step."""

    tension_floor: bool
    molten: bool
    unstable: bool


def empty_tallies(rows):
    """The table (rows, columns) of tallies that kernels write to."""
    return np.zeros((rows, len(Tally._fields)))


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
):
    """Advance stress, density, energy and position of the particles begin..end of one body.

    ``nodes`` is the table of the mapped velocities; the tally goes to one row of ``tallies``. ``whole_work`` 1 stores
    the energy with the new stress' half of the work of this velocity gradient, 0 leaves that half to the forces that
    follow. ``time`` is that of the new stress.
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
            lanes = within & (load(table, MASS, p, within) > 0.0)  # what has left the grid has none
            hoop = hoop_factor(geometry, load(table, X, p, lanes))
            gradient = velocity_gradient(geometry, pack.lines, p - start, hoop)
            old = PointState(
                load(table, DENSITY, p, lanes),
                load(table, ENERGY, p, lanes),
                load(table, PRESSURE, p, lanes),
                load(table, VISCOSITY, p, lanes),
                (
                    load(table, S11, p, lanes),
                    load(table, S22, p, lanes),
                    load(table, S33, p, lanes),
                    load(table, S12, p, lanes),
                    load(table, S23, p, lanes),
                    load(table, S31, p, lanes),
                ),
                load(table, STRAIN, p, lanes),
                load(table, KELVIN, p, lanes),
                load(table, DAMAGE, p, lanes),
                load(table, HARDENED, p, lanes) if weakens(matter.failure) else none,
                load(table, STORED, p, lanes) if stored_part(matter.strength) > 0.0 else none,
            )
            eos = burning(matter.eos, table, p, lanes, time, geometry.spacing)
            local = Matter(
                eos,
                matter.strength,
                matter.tension,
                matter.shear_modulus,
                matter.room_temperature,
                matter.melt_temperature,
                matter.failure,
            )
            length = own_length(geometry, p, lanes)
            new, present, acts = advance(local, viscosity, length, dt, gradient, old, stress_rate)
            store(table, DENSITY, p, new.density, lanes)
            energy = present if whole_work else new.energy
            store(table, ENERGY, p, energy, lanes)
            store(table, PRESSURE, p, new.pressure, lanes)
            store(table, VISCOSITY, p, new.viscosity, lanes)
            store(table, S11, p, new.deviator[0], lanes)
            store(table, S22, p, new.deviator[1], lanes)
            store(table, S33, p, new.deviator[2], lanes)
            store(table, S12, p, new.deviator[3], lanes)
            store(table, S23, p, new.deviator[4], lanes)
            store(table, S31, p, new.deviator[5], lanes)
            store(table, STRAIN, p, new.plastic_strain, lanes)
            store(table, KELVIN, p, maximum(new.temperature, 0.0), lanes)
            store(table, DAMAGE, p, new.damage, lanes)
            if weakens(matter.failure):
                store(table, HARDENED, p, new.hardened, lanes)
            if stored_part(matter.strength) > 0.0:
                store(table, STORED, p, new.stored, lanes)
            place = none
            past = lanes & (none > 0.0)
            for axis in range(3):
                coordinate = load(table, NEW_X + axis, p, lanes)
                store(table, X + axis, p, coordinate, lanes)
                place = place + coordinate
                if axis < dimensions(geometry):
                    cells = (coordinate - geometry.lower[axis]) * inverse
                    past = past | (cells < 0.0) | (cells >= geometry.cells[axis])
            vx, vy = load(table, VX, p, lanes), load(table, VY, p, lanes)
            vz = load(table, VZ, p, lanes)
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
def advance(matter, viscosity, spacing, dt, gradient, old, stress_rate=JAUMANN):
    """Points over one step with a velocity gradient (tensor.py): the new state, the energy at its time, and the Acts.

    Density and pressure live at the new time, and so does the energy to come; the Point's own energy lacks the half of
    the new stress' work. The gradient belongs to the step between.
    """
    strain, trace = strain_increment(gradient, dt)
    ratio = volume_ratio(gradient, dt)
    density = old.density / ratio
    per_mass = 1.0 / old.density
    per_time = 1.0 / dt
    density_ratio = old.density * (1.0 / reference_density(matter.eos))
    homologous = homologous_temperature(matter, old.temperature, density_ratio)

    shape_change = deviator(strain, trace)
    stiff = relative_stiffness(matter, density, old.pressure, old.temperature)
    modulus = matter.shear_modulus * stiff
    turned = carried(stress_rate, gradient, old.deviator, dt)
    trial = added(turned, shape_change, 2.0 * modulus)
    rate = equivalent_strain(shape_change) * per_time
    strength = under_pressure(matter.strength, matter.eos, density, old.energy)
    left = integrity(matter.failure, old.damage)
    hardened = old.hardened if weakens(matter.failure) else old.plastic_strain
    factor = rate_and_heat(strength, rate, homologous, stiff) * left
    new_deviator, slip = return_to_yield(strength, trial, modulus, hardened, factor, left)
    equivalent = equivalent_stress(new_deviator)
    stored = old.stored
    if stored_part(strength) > 0.0:
        stored = stored + stored_part(strength) * equivalent * slip * per_mass

    sound = sound_speed_squared(matter.eos, old.density, old.energy, old.pressure)
    q = artificial_viscosity(viscosity, density, sqrt(maximum(sound, 0.0)), spacing, trace * per_time)

    # Energy at the time of the velocity: the second half of the work of the old stress, see step.py.
    old_work = contract(old.deviator, shape_change) - trace * (old.pressure + viscosity.heating * old.viscosity)
    energy = old.energy + 0.5 * old_work * per_mass
    # Energy at the time of the density: half the work of the new stress on top; e = known - p dv / 2.
    expansion = (ratio - 1.0) * per_mass
    known = energy + 0.5 * contract(new_deviator, shape_change) * per_mass
    known = known - 0.5 * viscosity.heating * q * expansion
    floor = floor_until_failure(matter.failure, pressure_floor(matter.tension, homologous))
    floor = alike(floor, density)
    pressure = solve_pressure(matter.eos, density, known, expansion, energy, floor)
    borne = maximum(pressure, floor)
    loading = PointLoading(
        old.plastic_strain + slip, slip, borne, -borne / maximum(equivalent, LEAST_STRESS), rate, homologous, dt
    )
    damage = grown_damage(matter.failure, old.damage, loading)
    failed = damage >= 1.0
    if anywhere(failed):  # neither shear nor tension, from this step on
        lost = 0.5 * contract(new_deviator, shape_change) * per_mass
        known = where(failed, known - lost, known)
        new_deviator = scaled(new_deviator, where(failed, 0.0, 1.0))
        floor = where(failed, 0.0, floor)
        empty = solve_pressure(matter.eos, density, known, expansion, energy, floor)
        pressure = where(failed, empty, pressure)
        slip = where(failed & (old.damage >= 1.0), 0.0, slip)
    acts = Acts(pressure < floor, homologous >= 1.0, sound < 0.0)
    pressure = maximum(pressure, floor)
    present = known - 0.5 * pressure * expansion  # with the pressure that is stored
    new = PointState(
        density,
        energy,
        pressure,
        q,
        new_deviator,
        old.plastic_strain + slip,
        temperature(matter.eos, density, present - stored),
        damage,
        hardened + left * slip,
        stored,
    )
    return new, present, acts


@device
def homologous_temperature(matter, kelvin, density_ratio):
    """(T - T_room) / (T_melt - T_room) within 0..1; 0 for matter that never melts."""
    melt = matter.melt_temperature * melting(matter.strength, density_ratio)
    liquid = melt <= matter.room_temperature
    range_of_solid = where(liquid, 1.0, melt - matter.room_temperature)
    part = (kelvin - matter.room_temperature) * (1.0 / range_of_solid)
    part = minimum(maximum(part, 0.0), 1.0)
    return where(liquid, 1.0, part)


@device
def relative_stiffness(matter, density, pressure, kelvin):
    """G / G0; without thermal softening the temperature is not needed."""
    kelvin = where(math.isinf(matter.melt_temperature), matter.room_temperature, kelvin)
    density_ratio = density * (1.0 / reference_density(matter.eos))
    return stiffness(matter.strength, density_ratio, pressure, kelvin)


@device
def artificial_viscosity(viscosity, density, sound_speed, spacing, rate):
    """q in Pa, in compression only; the length is the cell, not the stretched particle."""
    jump = maximum(-rate, 0.0) * spacing
    return density * jump * (viscosity.linear * sound_speed + viscosity.quadratic * jump)


@device
def return_to_yield(strength, trial, modulus, plastic_strain, factor, share=1.0):
    """Radial return of a trial deviator; gives the deviator on the surface and the plastic strain increment.

    Solves trial - 3 G d = sigma_y(eps_p + s d) by Newton's rule; s is the ``share`` of d that hardens. The left side
    falls and the slope of the right one does not grow, so that the answer is approached from below. From a strain of
    zero, where the slope may be infinite, the first step is too long and the next ones go back, never to zero. Of a
    step d at most half d^2 / eps_p times the slope is left, as in a power law, and decides whether another one is
    needed. The rate in ``factor`` (of the hardening) is that of the total deviatoric strain, whose elastic part is of
    the order of sigma_y / G and does not matter where strain is large.
    """
    size = equivalent_stress(trial)
    limit, slope = hardening(strength, plastic_strain)
    excess = size - alike(limit * factor, size)
    yielding = ~(excess <= 0.0)  # NaN yields, and so stays visible
    slip = alike(0.0, size)
    if not anywhere(yielding):
        return trial, slip
    steep = alike(3.0 * modulus, size)
    seeking = yielding
    for _ in range(NEWTONS):
        stiff = alike(slope * factor * share, size)
        step = excess / (steep + stiff)
        tolerated = RETURN_TOLERANCE * size * (plastic_strain + share * slip)
        slip = where(seeking, maximum(slip + step, NEWTON_BACK * slip), slip)
        seeking = seeking & (0.5 * stiff * step * step >= tolerated)
        if not anywhere(seeking):
            break
        limit, slope = hardening(strength, plastic_strain + share * slip)
        excess = size - steep * slip - alike(limit * factor, size)
    return scaled(trial, where(yielding, 1.0 - steep * slip / size, 1.0)), slip


@device
def signal_speed(matter, viscosity, spacing, rate, point):
    """Fastest signal in a point at rest, m/s, and 1 if its sound is the floor: longitudinal waves and viscosity.

    With viscosity the stable step is dt (Q + sqrt(Q^2 + c^2)) < h: Benson (1992), Comput. Methods Appl. Mech. Eng. 99,
    235.
    """
    slowest = SOUND_SPEED_FLOOR * reference_sound_speed(matter.eos)
    bulk = sound_speed_squared(matter.eos, point.density, point.energy, point.pressure)
    modulus = matter.shear_modulus * relative_stiffness(matter, point.density, point.pressure, point.temperature)
    longitudinal = bulk + 4.0 / 3.0 * modulus / point.density
    sound = maximum(longitudinal, slowest * slowest)
    squeezed = maximum(-rate, 0.0)
    damping = viscosity.quadratic * spacing * squeezed
    damping = damping + where(squeezed > 0.0, viscosity.linear * sqrt(sound), 0.0)
    return damping + sqrt(damping * damping + sound), longitudinal < slowest * slowest


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


def find_fault(matter, limits, particles, p):
    """Kind and value of an unphysical state of a particle, PHYSICAL for none."""
    ratio = particles.density[p] / reference_density(matter.eos)
    speed = float(np.linalg.norm(particles.velocity[p]))
    stress = particles.pressure[p] + particles.viscosity[p] + particles.deviator[p].sum()
    stress += particles.plastic_strain[p] + particles.temperature[p]
    place = particles.position[p].sum()
    checks = (
        (BAD_DENSITY, limits.thinnest < ratio < limits.densest, particles.density[p]),
        (BAD_ENERGY, abs(particles.energy[p]) < limits.energy, particles.energy[p]),
        (BAD_PRESSURE, math.isfinite(stress), particles.pressure[p]),
        (BAD_SPEED, speed < limits.speed, speed),
        (BAD_POSITION, math.isfinite(place), place),
    )
    for kind, physical, value in checks:
        if not physical:
            return kind, float(value)
    return PHYSICAL, 0.0
