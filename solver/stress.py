"""Stress update of one body: strain rate, spin, return to the yield surface, pressure, energy, failure, temperature.

Called body by body, because the laws are chosen by the types in its ``Matter``. Chunks of fixed size make the tallies
independent of the number of threads.
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
from solver.geometry import exit_face
from solver.jit import device, kernel
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
from solver.transfer import gather_velocity_gradient, new_stencil

CHUNK = 1024  # particles whose tallies are kept together

# Of the trial stress: the relative error of the plastic strain increment. The stress itself is on the surface exactly.
RETURN_TOLERANCE = 1e-5
SECANTS, HALVINGS = 30, 60  # tries of each rule; the second leaves 1e-18 of the elastic strain

# Of c0, in the time step only: an expanded solid has no sound to speak of, and steps without bound would follow.
SOUND_SPEED_FLOOR = 0.2

# Kinds of unphysical state, as kernels report them; the text is what the error says.
QUANTITIES = ("", "density", "specific internal energy", "pressure", "speed", "position")
SOUND, BAD_DENSITY, BAD_ENERGY, BAD_PRESSURE, BAD_SPEED, BAD_POSITION = range(6)


class Limits(NamedTuple):
    """Where a state stops being physical."""

    densest: float  # times the reference density
    thinnest: float  # times the reference density
    energy: float  # J/kg, either sign
    speed: float  # m/s


class Tally(NamedTuple):
    """What the chunks of one step report; each array has one row a chunk."""

    signal: np.ndarray  # largest signal speed + particle speed, m/s
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
    fault: np.ndarray  # 0 or the first kind of unphysical state
    culprit: np.ndarray  # its particle
    value: np.ndarray  # and the value


class Point(NamedTuple):
    """The state of one particle that the laws act on."""

    density: float
    energy: float
    pressure: float
    viscosity: float
    deviator: tuple[float, float, float, float, float, float]
    plastic_strain: float
    temperature: float
    damage: float = 0.0


class Acts(NamedTuple):
    """Which safeguards acted on a point in a step, each 0 or 1."""

    tension_floor: int
    molten: int
    unstable: int


def empty_tally(chunks):
    """A tally for a number of chunks."""
    real = ("signal", "volume_rate", "value")
    return Tally(
        **{name: np.zeros(chunks, float if name in real else np.int64) for name in Tally._fields}
    )


def chunks_of(count):
    """Chunks that hold a number of particles."""
    return -(-count // CHUNK)


@kernel
def update_chunks(
    geometry,
    shape,
    matter,
    viscosity,
    limits,
    particles,
    moved,
    begin,
    end,
    nodes,
    tally,
    row,
    dt,
    keep,
):
    """Advance stress, density, energy and position of the particles begin..end of one body.

    The tally of each chunk of ``CHUNK`` particles goes to its own row, from ``row`` on. ``keep`` 1 stores the energy
    with the new stress' half of the work of this velocity gradient, 0 leaves that half to the forces that follow.
    """
    for start in range(begin, end, CHUNK):
        stop = min(start + CHUNK, end)
        _update_chunk(
            geometry,
            shape,
            matter,
            viscosity,
            limits,
            particles,
            moved,
            start,
            stop,
            nodes,
            tally,
            row,
            dt,
            keep,
        )
        row += 1


@device
def _update_chunk(
    geometry,
    shape,
    matter,
    viscosity,
    limits,
    particles,
    moved,
    start,
    stop,
    nodes,
    tally,
    row,
    dt,
    keep,
):
    # Arrays by their own names: taking them from a record inside the loop costs their reference counts each time.
    position, velocity, alive = particles.position, particles.velocity, particles.alive
    density, energy, pressure = particles.density, particles.energy, particles.pressure
    q, s, kelvin = particles.viscosity, particles.deviator, particles.temperature
    plastic_strain, damage = particles.plastic_strain, particles.damage
    stencil = new_stencil(geometry, shape)
    gradient = np.empty((3, 3))
    signal = volume_rate = value = 0.0
    floors = beyond = below = cold = molten = slow = unstable = failed = 0
    outside = fault = culprit = 0
    for p in range(start, stop):
        if not alive[p]:
            continue
        gather_velocity_gradient(geometry, shape, position, p, nodes, stencil, gradient)
        deviatoric = (s[p, 0], s[p, 1], s[p, 2], s[p, 3], s[p, 4], s[p, 5])
        old = Point(
            density[p],
            energy[p],
            pressure[p],
            q[p],
            deviatoric,
            plastic_strain[p],
            kelvin[p],
            damage[p],
        )
        new, present, acts = advance(matter, viscosity, geometry.spacing, dt, gradient, old)
        density[p] = new.density
        energy[p] = present if keep else new.energy
        pressure[p] = new.pressure
        q[p] = new.viscosity
        plastic_strain[p] = new.plastic_strain
        kelvin[p] = max(new.temperature, 0.0)
        damage[p] = new.damage
        s[p, 0], s[p, 1], s[p, 2] = new.deviator[0], new.deviator[1], new.deviator[2]
        s[p, 3], s[p, 4], s[p, 5] = new.deviator[3], new.deviator[4], new.deviator[5]
        position[p, 0] = moved[p, 0]
        position[p, 1] = moved[p, 1]
        position[p, 2] = moved[p, 2]

        rate = gradient[0, 0] + gradient[1, 1] + gradient[2, 2]
        speed = math.sqrt(velocity[p, 0] ** 2 + velocity[p, 1] ** 2 + velocity[p, 2] ** 2)
        own, floored = signal_speed(matter, viscosity, geometry.spacing, rate, new)
        signal = max(signal, speed + own)
        volume_rate = max(volume_rate, abs(rate))
        floors += acts.tension_floor
        molten += acts.molten
        unstable += acts.unstable
        slow += floored
        beyond += outside_range(matter.eos, new.density)
        below += below_range(matter.eos, new.density)
        cold += new.temperature < 0.0
        failed += (new.damage >= 1.0) > (old.damage >= 1.0)
        outside += exit_face(geometry, position, p) >= 0
        if fault == 0:
            place = position[p, 0] + position[p, 1] + position[p, 2]
            fault, value = find_fault(matter, limits, new, speed, place)
            culprit = p
    tally.signal[row], tally.volume_rate[row] = signal, volume_rate
    tally.tension_floors[row], tally.molten[row] = floors, molten
    tally.beyond_hugoniot[row], tally.below_expansion[row] = beyond, below
    tally.sound_floors[row], tally.unstable[row] = slow, unstable
    tally.below_zero_kelvin[row], tally.failed[row], tally.outside[row] = cold, failed, outside
    tally.fault[row], tally.culprit[row], tally.value[row] = fault, culprit, value


@device
def advance(matter, viscosity, spacing, dt, gradient, old):
    """One point over one step with the velocity gradient (3, 3): the new Point, its energy to come, and the Acts.

    Density and pressure live at the new time, and so does the energy to come; the Point's own energy lacks the half of
    the new stress' work. The gradient belongs to the step between.
    """
    strain, trace = strain_increment(gradient, dt)
    ratio = volume_ratio(gradient, dt)
    density = old.density / ratio
    compression = old.density / reference_density(matter.eos)
    homologous = homologous_temperature(matter, old.temperature, compression)

    turned = rotated(old.deviator, spin_increment(gradient, dt))
    shape_change = deviator(strain, trace)
    stiff = relative_stiffness(matter, density, old.pressure, old.temperature)
    modulus = matter.shear_modulus * stiff
    trial = added(turned, shape_change, 2.0 * modulus)
    rate = equivalent_strain(shape_change) / dt
    factor = rate_and_heat(matter.strength, rate, homologous, stiff)
    new_deviator, slip = return_to_yield(
        matter.strength, trial, modulus, old.plastic_strain, factor
    )

    sound = sound_speed_squared(matter.eos, old.density, old.energy, old.pressure)
    q = artificial_viscosity(viscosity, density, math.sqrt(max(sound, 0.0)), spacing, trace / dt)

    # Energy at the time of the velocity: the second half of the work of the old stress, see step.py.
    old_work = contract(old.deviator, shape_change) - trace * (
        old.pressure + viscosity.heating * old.viscosity
    )
    energy = old.energy + 0.5 * old_work / old.density
    # Energy at the time of the density: half the work of the new stress on top; e = known - p dv / 2.
    expansion = (ratio - 1.0) / old.density
    known = energy + 0.5 * contract(new_deviator, shape_change) / old.density
    known -= 0.5 * viscosity.heating * q * expansion
    floor = floor_until_failure(matter.failure, pressure_floor(matter.tension, homologous))
    pressure = solve_pressure(matter.eos, density, known, expansion, energy, floor)
    carried = floor if pressure < floor else pressure
    damage = grown_damage(matter.failure, old.damage, old.plastic_strain + slip, carried, dt)
    if damage >= 1.0:  # neither shear nor tension, from this step on
        known -= 0.5 * contract(new_deviator, shape_change) / old.density
        new_deviator = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        floor = 0.0
        pressure = solve_pressure(matter.eos, density, known, expansion, energy, floor)
        if old.damage >= 1.0:
            slip = 0.0
    acts = Acts(int(pressure < floor), int(homologous >= 1.0), int(sound < 0.0))
    pressure = floor if pressure < floor else pressure
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
    if math.isinf(matter.melt_temperature):
        return 0.0
    melt = matter.melt_temperature * melting(matter.strength, compression)
    if melt <= matter.room_temperature:  # a liquid
        return 1.0
    part = (kelvin - matter.room_temperature) / (melt - matter.room_temperature)
    return min(max(part, 0.0), 1.0)


@device
def relative_stiffness(matter, density, pressure, kelvin):
    """Shear modulus over that at rest; heat does not matter to matter that never softens."""
    if math.isinf(matter.melt_temperature):
        kelvin = matter.room_temperature
    compression = density / reference_density(matter.eos)
    return stiffness(matter.strength, compression, pressure, kelvin)


@device
def artificial_viscosity(viscosity, density, sound_speed, spacing, rate):
    """q in Pa, in compression only; the length is the cell, not the stretched particle."""
    if rate >= 0.0:
        return 0.0
    jump = -rate * spacing
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
    limit = hardening(strength, plastic_strain) * factor
    if size <= limit:
        return trial, 0.0
    stiffness = 3.0 * modulus
    low, excess_low = 0.0, size - limit
    slip = excess_low / stiffness
    for _ in range(SECANTS):
        limit = hardening(strength, plastic_strain + slip) * factor
        excess = size - stiffness * slip - limit
        if abs(excess) <= RETURN_TOLERANCE * size:
            break
        step = excess * (slip - low) / (excess_low - excess)
        low, excess_low = slip, excess
        slip = max(slip + step, 0.0)
    else:
        low, high = 0.0, size / stiffness
        for _ in range(HALVINGS):
            slip = 0.5 * (low + high)
            limit = hardening(strength, plastic_strain + slip) * factor
            if size - stiffness * slip > limit:
                low = slip
            else:
                high = slip
    return scaled(trial, limit / size), slip


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
    sound = max(longitudinal, slowest * slowest)
    damping = 0.0
    if rate < 0.0:
        damping = viscosity.linear * math.sqrt(sound) - viscosity.quadratic * spacing * rate
    return damping + math.sqrt(damping * damping + sound), int(longitudinal < slowest * slowest)


@device
def find_fault(matter, limits, point, speed, place):
    """Kind and value of an unphysical state, (0, 0.0) for none; comparisons are written so that NaN fails them."""
    ratio = point.density / reference_density(matter.eos)
    stress = point.pressure + point.viscosity + contract(point.deviator, point.deviator)
    if not (limits.thinnest < ratio < limits.densest):
        return BAD_DENSITY, point.density
    if not abs(point.energy) < limits.energy:
        return BAD_ENERGY, point.energy
    if not math.isfinite(stress):
        return BAD_PRESSURE, point.pressure
    if not speed < limits.speed:
        return BAD_SPEED, speed
    if not math.isfinite(place):
        return BAD_POSITION, place
    return SOUND, 0.0
