"""Stress update of one body: strain rate, spin, return to the yield surface, pressure, energy, failure, temperature.

Called body by body, because the laws are chosen by the types in its ``Matter``, and eight particles at a time: the
laws are written without ``if``, for a point as for eight of them.
"""

import math
from typing import NamedTuple

from solver.jit import device
from solver.matter.eos import (
    density_at_rest,
    reference_density,
    reference_sound_speed,
    solve_pressure,
    sound_speed_squared,
    temperature_at,
)
from solver.matter.failure import (
    PointLoading,
    floor_until_failure,
    grown_damage,
    integrity,
    opens,
    void_fraction,
    weakens,
)
from solver.matter.melting import coherence, melting_point, with_fusion
from solver.matter.strength import hardening, rate_and_heat, stiffness, stored_part, under_pressure
from solver.matter.tension import linking, opens_by_flow, pressure_floor, void_growth
from solver.matter.tensor import (
    Jaumann,
    added,
    contract,
    deviator,
    equivalent_strain,
    equivalent_stress,
    scaled,
    strain_increment,
    transported,
    volume_ratio,
)
from solver.vectors import alike, anywhere, maximum, minimum, sqrt, where

RETURN_TOLERANCE = 1e-12  # distance of the stress from the yield surface, over the trial stress
# Steps of the rule, and what is left at least of an increment that was too long.
NEWTONS, NEWTON_BACK = (40, 1e-9)

# Of c0, in the time step only: an expanded solid has no sound to speak of, and steps without bound would follow.
SOUND_SPEED_FLOOR = 0.2

# Pa, of the equivalent stress in the triaxiality: matter that bears less is a liquid, and the ratio stays finite.
LEAST_STRESS = 1.0

# Part of the range from room temperature to melting within which matter held at its melting point has reached it.
ROUND_OFF = 1e-12

JAUMANN = Jaumann()


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
    parted: float = 0.0  # rate of growth of volume, or of shear, with which voids linked, 1/s; 0 while closed
    grown: float = 0.0  # logarithm of the factor by which plastic flow has made voids grow


class Acts(NamedTuple):
    """Safeguards that acted on a point in a step, and parts of its work, J/kg."""

    tension_floor: bool
    molten: bool
    unstable: bool
    sheared: float
    pulled: float
    damped: float


@device
def advance(matter, viscosity, spacing, dt, gradient, old, stress_rate=JAUMANN):
    """Points over one step with a velocity gradient (tensor.py): the new state, the energy at its time, and the Acts.

    Density and pressure live at the new time, and so does the energy to come; the state's own energy lacks the half of
    the new stress' work. The gradient belongs to the step between.
    """
    strain, trace = strain_increment(gradient, dt)
    ratio = volume_ratio(gradient, dt)
    density = old.density / ratio
    per_mass = 1.0 / old.density
    per_time = 1.0 / dt
    density_ratio = old.density * (1.0 / reference_density(matter.eos))
    homologous = homologous_temperature(matter, old.temperature, density_ratio)
    coherent = coherence(matter, old.temperature, density_ratio)
    apart = old.parted > 0.0

    shape_change = deviator(strain, trace)
    stiff = relative_stiffness(matter, density, old.pressure, old.temperature)
    modulus = matter.shear_modulus * stiff
    turned = transported(stress_rate, gradient, old.deviator, dt)
    trial = added(turned, shape_change, 2.0 * modulus)
    rate = equivalent_strain(shape_change) * per_time
    strength = under_pressure(matter.strength, matter.eos, density, old.energy)
    left = integrity(matter.failure, old.damage)
    hardened = old.hardened if weakens(matter.failure) else old.plastic_strain
    factor = rate_and_heat(strength, rate, homologous, stiff) * left * where(apart, 0.0, coherent)
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
    floor = floor_until_failure(matter.failure, pressure_floor(matter.tension, homologous, coherent))
    floor = where(apart, 0.0, floor)
    if opens(matter.failure):
        voids = void_fraction(matter.failure, old.damage)
        pressure = pressure_around_voids(matter.eos, voids, density, known, expansion, energy, floor)
    else:
        pressure = solve_pressure(matter.eos, density, known, expansion, energy, floor)
    borne = maximum(pressure, floor)
    loading = PointLoading(
        old.plastic_strain + slip,
        slip,
        borne,
        -borne / maximum(equivalent, LEAST_STRESS),
        rate,
        homologous,
        dt,
        coherent,
    )
    damage = grown_damage(matter.failure, old.damage, loading)
    if opens(matter.failure):
        voids = void_fraction(matter.failure, damage)
        if anywhere(voids > 0.0):
            pressure = pressure_around_voids(matter.eos, voids, density, known, expansion, energy, floor)
    failed = damage >= 1.0
    if anywhere(failed):  # no tension, and no shear but that of rubble, from this step on
        lost = 0.5 * contract(new_deviator, shape_change) * per_mass
        known = where(failed, known - lost, known)
        new_deviator = scaled(new_deviator, where(failed, 0.0, 1.0))
        if matter.rubble_friction > 0.0:
            limit = math.sqrt(3.0) * matter.rubble_friction * maximum(borne, 0.0)
            share = minimum(limit / maximum(equivalent_stress(trial), LEAST_STRESS), 1.0)
            share = where(failed, share, 0.0)
            new_deviator = added(new_deviator, trial, share)
            known = known + 0.5 * share * contract(trial, shape_change) * per_mass
        floor = where(failed, 0.0, floor)
        empty = solve_pressure(matter.eos, density, known, expansion, energy, floor)
        pressure = where(failed, empty, pressure)
        slip = where(failed & (old.damage >= 1.0), 0.0, slip)
    parted, grown = old.parted, old.grown
    if linking(matter.tension) < 1.0:  # closed again, matter is whole
        grown = grown + void_growth(matter.tension, loading)
        opened = density < (1.0 - linking(matter.tension)) * density_at_rest(matter.eos, known)
        opened = opened | opens_by_flow(matter.tension, grown)
        parted = where(apart, parted, where(opened, maximum(trace * per_time, rate), 0.0))
        parted = where(pressure < 0.0, parted, 0.0)
    is_floored = pressure < floor
    pressure = maximum(pressure, floor)
    acts = Acts(
        is_floored,
        (homologous >= 1.0) | (coherent <= 0.0),
        sound < 0.0,
        0.5 * (contract(old.deviator, shape_change) + contract(new_deviator, shape_change)) * per_mass,
        0.5 * (maximum(-old.pressure, 0.0) * trace * per_mass + maximum(-pressure, 0.0) * expansion),
        -0.5 * viscosity.heating * (old.viscosity * trace * per_mass + q * expansion),
    )
    present = known - 0.5 * pressure * expansion  # with the pressure that is stored
    kelvin = temperature_at(matter.eos, density, present - stored)
    new = PointState(
        density,
        energy,
        pressure,
        q,
        new_deviator,
        old.plastic_strain + slip,
        with_fusion(matter, kelvin, density * (1.0 / reference_density(matter.eos))),
        damage,
        hardened + left * slip,
        stored,
        parted,
        grown,
    )
    return new, present, acts


@device
def pressure_around_voids(eos, voids, density, known, expansion, guess, floor):
    """Pressure as of ``solve_pressure`` of matter with voids, a part of its volume under tension; closed, none."""
    closed = solve_pressure(eos, density, known, expansion, guess, floor)
    if not anywhere(voids > 0.0):
        return closed
    stretched = solve_pressure(eos, density / (1.0 - voids), known, expansion, guess, floor)
    return where(stretched < 0.0, stretched, maximum(closed, 0.0))


@device
def homologous_temperature(matter, kelvin, density_ratio):
    """(T - T_room) / (T_melt - T_room) within 0..1; 0 for matter that never melts."""
    melt = melting_point(matter, density_ratio)
    liquid = melt <= matter.room_temperature
    range_of_solid = where(liquid, 1.0, melt - matter.room_temperature)
    part = (kelvin - matter.room_temperature) * (1.0 / range_of_solid)
    return where(liquid | (part >= 1.0 - ROUND_OFF), 1.0, maximum(part, 0.0))


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
def return_to_yield(strength, trial, modulus, plastic_strain, factor, part=1.0):
    """Radial return of a trial deviator; gives the deviator on the surface and the plastic strain increment.

    Solves trial - 3 G d = sigma_y(eps_p + s d) by Newton's rule; s is the ``part`` of d that hardens. The left side
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
        stiff = alike(slope * factor * part, size)
        step = excess / (steep + stiff)
        tolerated = RETURN_TOLERANCE * size * (plastic_strain + part * slip)
        slip = where(seeking, maximum(slip + step, NEWTON_BACK * slip), slip)
        seeking = seeking & (0.5 * stiff * step * step >= tolerated)
        if not anywhere(seeking):
            break
        limit, slope = hardening(strength, plastic_strain + part * slip)
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
