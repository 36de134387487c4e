"""Stress update of one body: strain rate, spin, return to the yield surface, pressure, energy, temperature.

Called body by body, because the laws are chosen by the types in its ``Matter``. Chunks of fixed size make the tallies
independent of the number of threads.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.eos import (
    outside_range,
    pressure_terms,
    reference_density,
    reference_sound_speed,
    sound_speed_squared,
    temperature,
)
from solver.failure import pressure_floor
from solver.geometry import exit_face
from solver.jit import device, kernel
from solver.strength import hardening, rate_and_heat
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
)
from solver.transfer import gather_velocity_gradient, new_stencil

CHUNK = 1024  # particles whose tallies are kept together
RETURN_TOLERANCE = 1e-5  # of the trial stress: the relative error of the plastic strain increment; the stress itself
# lies on the surface exactly
SOUND_SPEED_FLOOR = (
    0.2  # of c0, in the time step only: expanded matter must not stop it from falling
)

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
    below_zero_kelvin: np.ndarray  # particles whose temperature was lifted to 0 K
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
    geometry, shape, matter, viscosity, limits, particles, moved, begin, end, nodes, tally, row, dt
):
    """Advance stress, density, energy and position of the particles begin..end of one body.

    The tally of each chunk of ``CHUNK`` particles goes to its own row, from ``row`` on.
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
        )
        row += 1


@device
def _update_chunk(
    geometry, shape, matter, viscosity, limits, particles, moved, start, stop, nodes, tally, row, dt
):
    stencil = new_stencil(geometry, shape)
    gradient = np.empty((3, 3))
    _clear_row(tally, row)
    for p in range(start, stop):
        if not particles.alive[p]:
            continue
        gather_velocity_gradient(geometry, shape, particles.position, p, nodes, stencil, gradient)
        old = _read(particles, p)
        new, floored = advance(matter, viscosity, geometry.spacing, dt, gradient, old)
        if new.temperature < 0.0:
            tally.below_zero_kelvin[row] += 1
        if outside_range(matter.eos, new.density):
            tally.beyond_hugoniot[row] += 1
        tally.tension_floors[row] += floored
        _write(particles, p, new)
        particles.position[p, 0] = moved[p, 0]
        particles.position[p, 1] = moved[p, 1]
        particles.position[p, 2] = moved[p, 2]
        if exit_face(geometry, particles.position, p) >= 0:
            tally.outside[row] += 1
        _tally_speeds(matter, viscosity, geometry.spacing, particles, p, gradient, new, tally, row)
        if tally.fault[row] == 0:
            _find_fault(matter, limits, particles, p, new, tally, row)


@device
def _clear_row(tally, row):
    tally.signal[row] = 0.0
    tally.volume_rate[row] = 0.0
    tally.tension_floors[row] = 0
    tally.beyond_hugoniot[row] = 0
    tally.below_zero_kelvin[row] = 0
    tally.outside[row] = 0
    tally.fault[row] = 0


@device
def _read(particles, p):
    s = particles.deviator
    return Point(
        particles.density[p],
        particles.energy[p],
        particles.pressure[p],
        particles.viscosity[p],
        (s[p, 0], s[p, 1], s[p, 2], s[p, 3], s[p, 4], s[p, 5]),
        particles.plastic_strain[p],
        particles.temperature[p],
    )


@device
def _write(particles, p, point):
    particles.density[p] = point.density
    particles.energy[p] = point.energy
    particles.pressure[p] = point.pressure
    particles.viscosity[p] = point.viscosity
    particles.plastic_strain[p] = point.plastic_strain
    particles.temperature[p] = max(point.temperature, 0.0)
    for component in range(6):
        particles.deviator[p, component] = point.deviator[component]


@device
def advance(matter, viscosity, spacing, dt, gradient, old):
    """One point over one step with the velocity gradient (3, 3); returns the new Point and 1 if its tension was cut.

    Density, energy and pressure live at the new time; the gradient belongs to the step between.
    """
    strain, trace = strain_increment(gradient, dt)
    density = old.density * math.exp(-trace)  # exact for a constant rate; cannot turn negative
    homologous = homologous_temperature(matter, old.temperature)

    turned = rotated(old.deviator, spin_increment(gradient, dt))
    shape_change = deviator(strain, trace)
    modulus = matter.shear_modulus * min(1.0, density / reference_density(matter.eos))
    trial = added(turned, shape_change, 2.0 * modulus)
    rate = equivalent_strain(shape_change) / dt
    new_deviator, slip = return_to_yield(
        matter.strength, trial, modulus, old.plastic_strain, rate, homologous
    )

    sound = max(sound_speed_squared(matter.eos, old.density, old.energy, old.pressure), 0.0)
    q = artificial_viscosity(viscosity, density, math.sqrt(sound), spacing, trace / dt)

    # Energy with the work of the mean stress over the step; e1 = known - (p0 + p1) dv / 2 and p1 = a + b e1.
    expansion = 1.0 / density - 1.0 / old.density
    mean_volume = 0.5 * (1.0 / density + 1.0 / old.density)
    shear_work = (
        0.5 * mean_volume * (contract(turned, shape_change) + contract(new_deviator, shape_change))
    )
    viscous_work = 0.5 * viscosity.heating * (old.viscosity + q) * expansion
    known = old.energy + shear_work - viscous_work - 0.5 * old.pressure * expansion
    a, b = pressure_terms(matter.eos, density)
    pressure = (a + b * known) / (1.0 + 0.5 * b * expansion)
    floor = pressure_floor(matter.tension, homologous)
    floored = 0
    if pressure < floor:
        pressure = floor
        floored = 1
    energy = known - 0.5 * pressure * expansion  # the work of the pressure that is stored
    new = Point(
        density,
        energy,
        pressure,
        q,
        new_deviator,
        old.plastic_strain + slip,
        temperature(matter.eos, density, energy),
    )
    return new, floored


@device
def homologous_temperature(matter, kelvin):
    """(T - T_room) / (T_melt - T_room) within 0..1; 0 for matter that never melts."""
    if math.isinf(matter.melt_temperature):
        return 0.0
    part = (kelvin - matter.room_temperature) / (matter.melt_temperature - matter.room_temperature)
    return min(max(part, 0.0), 1.0)


@device
def artificial_viscosity(viscosity, density, sound_speed, spacing, rate):
    """q in Pa, in compression only; the length is the cell, not the stretched particle."""
    if rate >= 0.0:
        return 0.0
    jump = -rate * spacing
    return density * jump * (viscosity.linear * sound_speed + viscosity.quadratic * jump)


@device
def return_to_yield(strength, trial, modulus, plastic_strain, rate, homologous):
    """Radial return of a trial deviator; gives the deviator on the surface and the plastic strain increment.

    Solves trial - 3 G d = sigma_y(eps_p + d) by the secant rule; the left side falls and the right one does not, so the
    two starting points enclose the answer. The rate is that of the total deviatoric strain, whose elastic part
    is of the order of sigma_y / G and does not matter where strain is large.
    """
    size = equivalent_stress(trial)
    factor = rate_and_heat(strength, rate, homologous)
    limit = hardening(strength, plastic_strain) * factor
    if size <= limit:
        return trial, 0.0
    stiffness = 3.0 * modulus
    low, excess_low = 0.0, size - limit
    slip = excess_low / stiffness
    for _ in range(30):
        limit = hardening(strength, plastic_strain + slip) * factor
        excess = size - stiffness * slip - limit
        if abs(excess) <= RETURN_TOLERANCE * size:
            break
        step = excess * (slip - low) / (excess_low - excess)
        low, excess_low = slip, excess
        slip = max(slip + step, 0.0)
    return scaled(trial, limit / size), slip


@device
def _tally_speeds(matter, viscosity, spacing, particles, p, gradient, point, tally, row):
    rate = gradient[0, 0] + gradient[1, 1] + gradient[2, 2]
    slowest = SOUND_SPEED_FLOOR * reference_sound_speed(matter.eos)
    bulk = sound_speed_squared(matter.eos, point.density, point.energy, point.pressure)
    modulus = matter.shear_modulus * min(1.0, point.density / reference_density(matter.eos))
    sound = max(bulk + 4.0 / 3.0 * modulus / point.density, slowest * slowest)
    damping = 0.0
    if rate < 0.0:
        damping = viscosity.linear * math.sqrt(sound) - viscosity.quadratic * spacing * rate
    speed = math.sqrt(
        particles.velocity[p, 0] ** 2
        + particles.velocity[p, 1] ** 2
        + particles.velocity[p, 2] ** 2
    )
    # Stability with viscosity: dt (Q + sqrt(Q^2 + c^2)) < h, Benson (1992), Comput. Methods Appl. Mech. Eng. 99, 235.
    signal = damping + math.sqrt(damping * damping + sound) + speed
    tally.signal[row] = max(tally.signal[row], signal)
    tally.volume_rate[row] = max(tally.volume_rate[row], abs(rate))


@device
def _find_fault(matter, limits, particles, p, point, tally, row):
    """Note the first unphysical state of a chunk; comparisons are written so that NaN fails them."""
    ratio = point.density / reference_density(matter.eos)
    speed = math.sqrt(
        particles.velocity[p, 0] ** 2
        + particles.velocity[p, 1] ** 2
        + particles.velocity[p, 2] ** 2
    )
    place = particles.position[p, 0] + particles.position[p, 1] + particles.position[p, 2]
    if not (limits.thinnest < ratio < limits.densest):
        _note(tally, row, BAD_DENSITY, p, point.density)
    elif not abs(point.energy) < limits.energy:
        _note(tally, row, BAD_ENERGY, p, point.energy)
    elif not math.isfinite(
        point.pressure + point.viscosity + contract(point.deviator, point.deviator)
    ):
        _note(tally, row, BAD_PRESSURE, p, point.pressure)
    elif not speed < limits.speed:
        _note(tally, row, BAD_SPEED, p, speed)
    elif not math.isfinite(place):
        _note(tally, row, BAD_POSITION, p, place)


@device
def _note(tally, row, fault, p, value):
    tally.fault[row] = fault
    tally.culprit[row] = p
    tally.value[row] = value
