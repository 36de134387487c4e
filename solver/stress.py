"""Stress update of one body: strain rate, spin, return to the yield surface, pressure, energy, failure, temperature.

Called body by body, because the laws are chosen by the types in its ``Matter``, and eight particles at a time: the
laws are written without ``if``, for a point as for eight of them.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.eos import (
    below_range,
    outside_range,
    reference_density,
    reference_sound_speed,
    solve_pressure,
    sound_speed_squared,
    temperature,
)
from solver.failure import floor_until_failure, grown_damage
from solver.geometry import PACK, dimensions, gather, hoop_factor, unpacked, velocity_gradient
from solver.jit import device, kernel
from solver.state import (
    DAMAGE,
    DENSITY,
    ENERGY,
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
    STRAIN,
    VISCOSITY,
    VX,
    VY,
    VZ,
    X,
)
from solver.strength import hardening, melting, rate_and_heat, stiffness
from solver.tension import pressure_floor
from solver.tensor import (
    added,
    contract,
    deviator,
    equivalent_strain,
    equivalent_stress,
    rotated,
    scaled,
    spin_increment,
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
    finite,
    first_lanes,
    largest,
    load,
    maximum,
    minimum,
    spread,
    sqrt,
    store,
    total,
    where,
)

# Of the trial stress: the relative error of the plastic strain increment. The stress itself is on the surface exactly.
RETURN_TOLERANCE = 1e-9
SECANTS, HALVINGS = 30, 60  # tries of each rule; the second leaves 1e-18 of the elastic strain

# Of c0, in the time step only: an expanded solid has no sound to speak of, and steps without bound would follow.
SOUND_SPEED_FLOOR = 0.2

# Kinds of unphysical state; the text is what the error says.
QUANTITIES = ("", "density", "specific internal energy", "pressure", "speed", "position")
PHYSICAL, BAD_DENSITY, BAD_ENERGY, BAD_PRESSURE, BAD_SPEED, BAD_POSITION = range(6)


class Limits(NamedTuple):
    """Where a state stops being physical."""

    densest: float  # times the reference density
    thinnest: float  # times the reference density
    energy: float  # J/kg, either sign
    speed: float  # m/s


class Tally(NamedTuple):
    """What the shares of the bodies report of one step; each array has one number a share."""

    signal: np.ndarray  # largest signal speed, m/s
    convected: np.ndarray  # largest signal speed + particle speed, m/s
    speed: np.ndarray  # largest particle speed, m/s
    volume_rate: np.ndarray  # largest |tr D|, 1/s
    tension_floors: np.ndarray  # particles whose pressure was lifted to the tensile floor
    beyond_hugoniot: np.ndarray  # particles denser than the range of the equation of state
    below_expansion: np.ndarray  # particles thinner than the range of the equation of state
    below_zero_kelvin: np.ndarray  # particles whose temperature was lifted to 0 K
    molten: np.ndarray  # particles whose homologous temperature was held at 1
    sound_floors: np.ndarray  # particles whose signal speed rests on the floor of the sound speed
    unstable: np.ndarray  # particles whose negative c^2 counted as zero for the viscosity
    failed: np.ndarray  # particles that failed in this step
    outside: np.ndarray  # particles now outside the grid, for ``faces.cross_faces``
    fault: np.ndarray  # 1 where a state is unphysical
    culprit: np.ndarray  # the first particle of the first eight among which one is


class Point(NamedTuple):
    """The state of one particle, or of eight, that the laws act on."""

    density: float
    energy: float
    pressure: float
    viscosity: float
    deviator: tuple[float, float, float, float, float, float]
    plastic_strain: float
    temperature: float
    damage: float = 0.0


class Acts(NamedTuple):
    """Which safeguards acted on a point in a step."""

    tension_floor: bool
    molten: bool
    unstable: bool


def empty_tally(shares):
    """A tally for a number of shares, and the table (shares, columns) that kernels write it to."""
    table = np.zeros((shares, len(Tally._fields)))
    return Tally(*table.T), table


@kernel
def update_particles(
    geometry, shape, pack, matter, viscosity, limits, table, begin, end, nodes, tally, row, dt, keep
):
    """Advance stress, density, energy and position of the particles begin..end of one body.

    ``nodes`` is the table of the mapped velocities; the tally goes to one row of its table. ``keep`` 1 stores
    the energy with the new stress' half of the work of this velocity gradient, 0 leaves that half to the forces that
    follow.
    """
    geometry = unpacked(geometry)
    index, weight, slope, lines = (
        bare(pack.first),
        bare(pack.weight),
        bare(pack.slope),
        bare(pack.lines),
    )
    table, nodes = bare(table), bare(nodes)
    none = spread(0.0)
    signal = convected = moving = fastest = none
    floors = beyond = below = cold = molten = slow = unstable = failed = outside = none
    fault, culprit = 0.0, 0.0
    inverse = 1.0 / geometry.spacing
    for start in range(begin, end, PACK):
        stop = min(start + PACK, end)
        find_nodes(geometry, shape, table, start, stop, index, weight, slope)
        for k in range(stop - start):
            gather(geometry, shape, k, index, weight, slope, nodes, lines)
        for p in range(start, stop, LANES):
            within = first_lanes(stop - p)
            lanes = within & (load(table, MASS, p, within) > 0.0)  # what has left the grid has none
            hoop = hoop_factor(geometry, load(table, X, p, lanes))
            gradient = velocity_gradient(geometry, lines, p - start, hoop)
            old = Point(
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
            )
            new, present, acts = advance(matter, viscosity, geometry.spacing, dt, gradient, old)
            store(table, DENSITY, p, new.density, lanes)
            energy = present if keep else new.energy
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
            own, floored = signal_speed(matter, viscosity, geometry.spacing, rate, new)
            signal = maximum(signal, where(lanes, own, 0.0))
            convected = maximum(convected, where(lanes, speed + own, 0.0))
            moving = maximum(moving, where(lanes, speed, 0.0))
            fastest = maximum(fastest, where(lanes, absolute(rate), 0.0))
            floors = floors + where(lanes & acts.tension_floor, 1.0, 0.0)
            molten = molten + where(lanes & acts.molten, 1.0, 0.0)
            unstable = unstable + where(lanes & acts.unstable, 1.0, 0.0)
            slow = slow + where(lanes & floored, 1.0, 0.0)
            beyond = beyond + where(lanes & outside_range(matter.eos, new.density), 1.0, 0.0)
            below = below + where(lanes & below_range(matter.eos, new.density), 1.0, 0.0)
            cold = cold + where(lanes & (new.temperature < 0.0), 1.0, 0.0)
            broken = (new.damage >= 1.0) & ~(old.damage >= 1.0)
            failed = failed + where(lanes & broken, 1.0, 0.0)
            outside = outside + where(lanes & past, 1.0, 0.0)
            physical = is_physical(matter, limits, new, energy, speed, place)
            if fault == 0.0 and anywhere(lanes & ~physical):
                fault, culprit = 1.0, float(p)
    tally[row, 0], tally[row, 1], tally[row, 2] = (
        largest(signal),
        largest(convected),
        largest(moving),
    )
    tally[row, 3], tally[row, 4], tally[row, 5] = largest(fastest), total(floors), total(beyond)
    tally[row, 6], tally[row, 7], tally[row, 8] = total(below), total(cold), total(molten)
    tally[row, 9], tally[row, 10], tally[row, 11] = total(slow), total(unstable), total(failed)
    tally[row, 12], tally[row, 13], tally[row, 14] = total(outside), fault, culprit


@device
def advance(matter, viscosity, spacing, dt, gradient, old):
    """Points over one step with a velocity gradient (tensor.py): the new Point, its energy to come, and the Acts.

    Density and pressure live at the new time, and so does the energy to come; the Point's own energy lacks the half of
    the new stress' work. The gradient belongs to the step between.
    """
    strain, trace = strain_increment(gradient, dt)
    ratio = volume_ratio(gradient, dt)
    density = old.density / ratio
    per_mass = 1.0 / old.density
    per_time = 1.0 / dt
    compression = old.density * (1.0 / reference_density(matter.eos))
    homologous = homologous_temperature(matter, old.temperature, compression)

    turned = rotated(old.deviator, spin_increment(gradient, dt))
    shape_change = deviator(strain, trace)
    stiff = relative_stiffness(matter, density, old.pressure, old.temperature)
    modulus = matter.shear_modulus * stiff
    trial = added(turned, shape_change, 2.0 * modulus)
    rate = equivalent_strain(shape_change) * per_time
    factor = rate_and_heat(matter.strength, rate, homologous, stiff)
    new_deviator, slip = return_to_yield(
        matter.strength, trial, modulus, old.plastic_strain, factor
    )

    sound = sound_speed_squared(matter.eos, old.density, old.energy, old.pressure)
    q = artificial_viscosity(
        viscosity, density, sqrt(maximum(sound, 0.0)), spacing, trace * per_time
    )

    # Energy at the time of the velocity: the second half of the work of the old stress, see step.py.
    old_work = contract(old.deviator, shape_change) - trace * (
        old.pressure + viscosity.heating * old.viscosity
    )
    energy = old.energy + 0.5 * old_work * per_mass
    # Energy at the time of the density: half the work of the new stress on top; e = known - p dv / 2.
    expansion = (ratio - 1.0) * per_mass
    known = energy + 0.5 * contract(new_deviator, shape_change) * per_mass
    known = known - 0.5 * viscosity.heating * q * expansion
    floor = floor_until_failure(matter.failure, pressure_floor(matter.tension, homologous))
    floor = alike(floor, density)
    pressure = solve_pressure(matter.eos, density, known, expansion, energy, floor)
    damage = grown_damage(
        matter.failure, old.damage, old.plastic_strain + slip, maximum(pressure, floor), dt
    )
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
    new = Point(
        density,
        energy,
        pressure,
        q,
        new_deviator,
        old.plastic_strain + slip,
        temperature(matter.eos, density, present),
        damage,
    )
    return new, present, acts


@device
def homologous_temperature(matter, kelvin, compression):
    """(T - T_room) / (T_melt - T_room) within 0..1; 0 for matter that never melts."""
    melt = matter.melt_temperature * melting(matter.strength, compression)
    liquid = melt <= matter.room_temperature
    range_of_solid = where(liquid, 1.0, melt - matter.room_temperature)
    part = (kelvin - matter.room_temperature) * (1.0 / range_of_solid)
    part = minimum(maximum(part, 0.0), 1.0)
    return where(liquid, 1.0, part)


@device
def relative_stiffness(matter, density, pressure, kelvin):
    """Shear modulus over that at rest; heat does not matter to matter that never softens."""
    kelvin = where(math.isinf(matter.melt_temperature), matter.room_temperature, kelvin)
    compression = density * (1.0 / reference_density(matter.eos))
    return stiffness(matter.strength, compression, pressure, kelvin)


@device
def artificial_viscosity(viscosity, density, sound_speed, spacing, rate):
    """q in Pa, in compression only; the length is the cell, not the stretched particle."""
    jump = maximum(-rate, 0.0) * spacing
    return density * jump * (viscosity.linear * sound_speed + viscosity.quadratic * jump)


@device
def return_to_yield(strength, trial, modulus, plastic_strain, factor):
    """Radial return of a trial deviator; gives the deviator on the surface and the plastic strain increment.

    Solves trial - 3 G d = sigma_y(eps_p + d) by the secant rule; the left side falls and the right one does not, so the
    two starting points enclose the answer. Where hardening begins as steep as a small power of a strain of zero the
    secants do not arrive, and halving does. The rate in ``factor`` (of the hardening) is that of the total deviatoric
    strain, whose elastic part is of the order of sigma_y / G and does not matter where strain is large.
    """
    size = equivalent_stress(trial)
    limit = alike(hardening(strength, plastic_strain) * factor, size)
    yielding = ~(size <= limit)  # NaN yields, and so stays visible
    slip = alike(0.0, size)
    if not anywhere(yielding):
        return trial, slip
    steep = alike(3.0 * modulus, size)
    low, excess_low = slip, size - limit
    slip = where(yielding, excess_low / steep, 0.0)
    seeking = yielding
    for _ in range(SECANTS):
        present = alike(hardening(strength, plastic_strain + slip) * factor, size)
        limit = where(seeking, present, limit)
        excess = size - steep * slip - limit
        seeking = seeking & (absolute(excess) > RETURN_TOLERANCE * size)
        if not anywhere(seeking):
            break
        step = excess * (slip - low) / (excess_low - excess)
        low, excess_low = where(seeking, slip, low), where(seeking, excess, excess_low)
        slip = where(seeking, maximum(slip + step, 0.0), slip)
    if anywhere(seeking):
        low, high = where(seeking, 0.0, slip), where(seeking, size / steep, slip)
        for _ in range(HALVINGS):
            slip = 0.5 * (low + high)
            present = alike(hardening(strength, plastic_strain + slip) * factor, size)
            limit = where(seeking, present, limit)
            beyond = size - steep * slip > limit
            low, high = where(beyond, slip, low), where(beyond, high, slip)
    return scaled(trial, where(yielding, limit / size, 1.0)), slip


@device
def signal_speed(matter, viscosity, spacing, rate, point):
    """Fastest signal in a point at rest, m/s, and 1 if its sound is the floor: longitudinal waves and viscosity.

    With viscosity the stable step is dt (Q + sqrt(Q^2 + c^2)) < h: Benson (1992), Comput. Methods Appl. Mech. Eng. 99,
    235.
    """
    slowest = SOUND_SPEED_FLOOR * reference_sound_speed(matter.eos)
    bulk = sound_speed_squared(matter.eos, point.density, point.energy, point.pressure)
    modulus = matter.shear_modulus * relative_stiffness(
        matter, point.density, point.pressure, point.temperature
    )
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
