"""The sums over neighbours: forces at n, and after them the velocity gradients at n+1.

With F (x_i - x_j) the gradient of W at i, B the correction and v_ij = v_i - v_j

    L_i = -(1 / rho_i) sum_j m_j v_ij (B_i grad W)^T                       velocity gradient
    T_i = sigma_i B_i / rho_i^2
    a_i = sum_j m_j (T_i + T_j - Pi_ij - R_ij) grad W                      its adjoint, and what is artificial
    e_i' = sigma_i : L_i / rho_i + 1/2 sum_j m_j v_ij . (Pi_ij + R_ij) grad W

the forces of a pair are opposite, and in the mean of the velocities before and after them they do the work that the
internal energies take: Bonet and Lok (1999), section 3; Monaghan (1992), Eqs. 3.3 and 4.1. Forces of shear have a
moment, which vanishes in the sum where B is there, because L_i of a rotation has no strain then.
"""

from typing import NamedTuple

import numpy as np

from solver import state
from solver.jit import device, kernel
from solver.matter.stress import PointState, signal_speed
from solver.methods.sph.neighbours import apart, row, rows
from solver.methods.sph.smoothing import height
from solver.methods.sph.tables import HEAVY, IMAGE, LENGTH, MOVED, RHO, SOUND, SPEED, T33
from solver.problem import ArtificialViscosity
from solver.steps.space import deviator_of
from solver.vectors import (
    LANES,
    bare,
    first_lanes,
    largest,
    load,
    maximum,
    minimum,
    number,
    power,
    spread,
    store,
    total,
    where,
)

STILL = ArtificialViscosity(0.0, 0.0)  # of the point update: viscosity acts between particles

SOFTENING = 0.01  # of h^2, added to the squared distance: Monaghan (1992)

# Of the viscosity's part in the signal speed, and of the path in a step under the force: Monaghan (1992), section 10.
VISCOUS = 0.6

# Places in the sums of a share: impulse of images, mass, work of gravity, largest inverse of a step, work of contact.
IMPULSE, WEIGHT, WORK, FASTEST, TOUCHED = 0, 3, 4, 5, 6


class Lists(NamedTuple):
    """Where the neighbours of each particle stand."""

    neighbours: np.ndarray  # (k,) int32, of a share
    first: np.ndarray  # (n,) int64
    stop: np.ndarray  # (n,) int64


@kernel
def measure(matter, ratio, dimensions, thinnest, table, begin, end, measures):
    """Smoothing lengths and sound speeds of the particles begin..end of a body, into the rows of ``measures`` (2, n).

    h = ratio (m / rho)^(1/d), with the density not below ``thinnest``: matter in flight does not reach ever farther.
    """
    none = spread(0.0)
    for p in range(begin, end, LANES):
        within = first_lanes(end - p)
        mass = load(table, state.MASS, p, within)
        lanes = within & (mass > 0.0)
        point = PointState(
            load(table, state.DENSITY, p, lanes),
            load(table, state.ENERGY, p, lanes),
            load(table, state.PRESSURE, p, lanes),
            none,
            (none, none, none, none, none, none),
            none,
            load(table, state.KELVIN, p, lanes),
        )
        volume = mass / maximum(point.density, thinnest)
        length = ratio * power(volume, 1.0 / dimensions)
        store(measures, 0, p, where(lanes, length, 0.0), within)
        sound, _ = signal_speed(matter, STILL, 1.0, none, point)
        store(measures, 1, p, where(lanes, sound, 0.0), within)


@kernel
def lay_out(table, measures, ranges, place, other):
    """What neighbours see of particles before the corrections are there."""
    for body in range(ranges.shape[0]):
        for i in range(ranges[body, 0], ranges[body, 1]):
            for axis in range(3):
                place[i, axis] = table[state.X + axis, i]
                place[i, SPEED + axis] = table[state.VX + axis, i]
            place[i, LENGTH], place[i, HEAVY] = measures[0, i], table[state.MASS, i]
            other[i, SOUND], other[i, RHO] = measures[1, i], table[state.DENSITY, i]
            other[i, IMAGE] = 0.0


@kernel
def set_stress(table, correction, ranges, stress, other):
    """T = sigma B / rho^2 of particles."""
    for body in range(ranges.shape[0]):
        for i in range(ranges[body, 0], ranges[body, 1]):
            over = 1.0 / (table[state.DENSITY, i] * table[state.DENSITY, i])
            pressure = table[state.PRESSURE, i]
            s11, s22, s33, s12, s23, s31 = deviator_of(table, i)
            s11, s22, s33 = s11 - pressure, s22 - pressure, s33 - pressure
            b11, b22, b33 = correction[i, 0], correction[i, 1], correction[i, 2]
            b12, b23, b31 = correction[i, 3], correction[i, 4], correction[i, 5]
            stress[i, 0] = over * (s11 * b11 + s12 * b12 + s31 * b31)
            stress[i, 1] = over * (s11 * b12 + s12 * b22 + s31 * b23)
            stress[i, 2] = over * (s11 * b31 + s12 * b23 + s31 * b33)
            stress[i, 3] = over * (s12 * b11 + s22 * b12 + s23 * b31)
            stress[i, 4] = over * (s12 * b12 + s22 * b22 + s23 * b23)
            stress[i, 5] = over * (s12 * b31 + s22 * b23 + s23 * b33)
            stress[i, 6] = over * (s31 * b11 + s23 * b12 + s33 * b31)
            stress[i, 7] = over * (s31 * b12 + s23 * b22 + s33 * b23)
            other[i, T33] = over * (s31 * b31 + s23 * b23 + s33 * b33)


@device
def viscous(smoothing, own, others, near, nearby, d, squared, length):
    """Pi of eight pairs, the speed mu of their approach, and v.x; ``near`` are rows of places, ``nearby`` of others.

    Pi = (-a c mu + b mu^2) / rho in Pa m6/kg2, with the means of both particles and mu = h v.x / (r^2 + 0.01 h^2) in
    m/s where they approach: Monaghan (1992), Annu. Rev. Astron. Astrophys. 30, 543, Eqs. 4.1 and 4.2.
    """
    along = (
        (own[SPEED] - near[SPEED]) * d[0]
        + (own[SPEED + 1] - near[SPEED + 1]) * d[1]
        + (own[SPEED + 2] - near[SPEED + 2]) * d[2]
    )
    mu = minimum(along, 0.0) * length / (squared + SOFTENING * length * length)
    sound, density = 0.5 * (others[SOUND] + nearby[SOUND]), 0.5 * (others[RHO] + nearby[RHO])
    viscosity = smoothing.viscosity
    return mu * (viscosity.quadratic * mu - viscosity.linear * sound) / density, mu, along


def tensile_part(smoothing, table):
    """R = e max(s, 0) / rho^2 along each principal axis of the stresses s of the particles of a table; (n, 6).

    Gray, Monaghan and Swift (2001), Comput. Methods Appl. Mech. Eng. 190, 6641, in three dimensions;
    where all stresses are alike, Monaghan (2000), J. Comput. Phys. 159, 290. A pull along an axis is opposed along it.
    """
    stress = table[state.S11 + np.array([0, 3, 5, 3, 1, 4, 5, 4, 2])].T.reshape(-1, 3, 3)
    stress = stress - table[state.PRESSURE][:, None, None] * np.eye(3)
    principal, axes = np.linalg.eigh(stress)
    over = smoothing.tensile / np.square(table[state.DENSITY])
    pulled = np.maximum(principal, 0.0) * over[:, None]
    part = np.einsum("nij,nj,nkj->nik", axes, pulled, axes)
    return part[:, [0, 1, 2, 0, 1, 2], [0, 1, 2, 1, 2, 0]]


@device
def opposed(smoothing, tensile, i, neighbours, k, q, gx, gy, gz):
    """The force R f grad W of the artificial stresses of both particles of eight pairs, that keeps them apart."""
    if smoothing.tensile > 0.0:
        own, near = row(tensile, i), rows(tensile, neighbours, k)
        part = repulsion(smoothing, q)
        r11, r22, r33 = own[0] + near[0], own[1] + near[1], own[2] + near[2]
        r12, r23, r31 = own[3] + near[3], own[4] + near[4], own[5] + near[5]
        return (
            part * (r11 * gx + r12 * gy + r31 * gz),
            part * (r12 * gx + r22 * gy + r23 * gz),
            part * (r31 * gx + r23 * gy + r33 * gz),
        )
    none = spread(0.0)
    return none, none, none


@device
def repulsion(smoothing, q):
    """(W(r) / W(spacing))^4, which the artificial stress is multiplied by: Monaghan (2000), Eq. 3.1, n = 4."""
    part = height(q)
    part = part / height(1.0 / smoothing.ratio)
    square = part * part
    return square * square


@device
def pull(stress, last, gx, gy, gz):
    """T grad W of eight pairs: a row of the table of stresses, and the last component of T, times a gradient."""
    return (
        (stress[0] * gx + stress[1] * gy) + stress[2] * gz,
        (stress[3] * gx + stress[4] * gy) + stress[5] * gz,
        (stress[6] * gx + stress[7] * gy) + last * gz,
    )


@kernel
def accelerate(smoothing, dimensions, tables, table, ranges, lists, pushed, gravity, kick, dt, sums):
    """Velocities after a ``kick`` (s) and positions after a step; the energy takes the half of the work before it.

    ``pushed`` (n, 8) are accelerations by contact. ``sums`` (8,) gets the impulse of images (3), the mass, the work of
    gravity, the largest inverse of a stable step for a Courant number of 1 (1/s), and the work of contact.
    """
    place, stress, other = bare(tables.place), bare(tables.stress), bare(tables.other)
    tensile = bare(tables.tensile)
    neighbours, moved = bare(lists.neighbours), tables.other
    none = spread(0.0)
    viscosity = smoothing.viscosity
    px = py = pz = weight = work = fastest = touched = 0.0
    for body in range(ranges.shape[0]):
        for i in range(ranges[body, 0], ranges[body, 1]):
            mass = table[state.MASS, i]
            if mass <= 0.0:
                continue
            own, t, others = row(place, i), row(stress, i), row(other, i)
            ax = ay = az = bx = by = bz = power_of_stress = heat = nearest = against = none
            for k in range(lists.first[i], lists.stop[i], LANES):
                near, s, nearby = (rows(place, neighbours, k), rows(stress, neighbours, k), rows(other, neighbours, k))
                d, squared, length, force, q = apart(dimensions, own, near)
                weighted = near[HEAVY] * force
                gx, gy, gz = weighted * d[0], weighted * d[1], weighted * d[2]
                pressure, mu, along = viscous(smoothing, own, others, near, nearby, d, squared, length)
                fx, fy, fz = pull(t, others[T33], gx, gy, gz)
                power_of_stress = power_of_stress - (
                    fx * (own[SPEED] - near[SPEED])
                    + fy * (own[SPEED + 1] - near[SPEED + 1])
                    + fz * (own[SPEED + 2] - near[SPEED + 2])
                )
                heat = heat + pressure * weighted * along
                sx, sy, sz = pull(s, nearby[T33], gx, gy, gz)
                rx, ry, rz = opposed(smoothing, tensile, i, neighbours, k, q, gx, gy, gz)
                against = against + (
                    rx * (own[SPEED] - near[SPEED])
                    + ry * (own[SPEED + 1] - near[SPEED + 1])
                    + rz * (own[SPEED + 2] - near[SPEED + 2])
                )
                fx, fy, fz = (fx + sx - pressure * gx - rx, fy + sy - pressure * gy - ry, fz + sz - pressure * gz - rz)
                ax, ay, az = ax + fx, ay + fy, az + fz
                bx, by, bz = (bx + nearby[IMAGE] * fx, by + nearby[IMAGE] * fy, bz + nearby[IMAGE] * fz)
                nearest = maximum(nearest, -mu)
            a = (
                total(ax) + gravity[0] + pushed[i, 0],
                total(ay) + gravity[1] + pushed[i, 1],
                total(az) + gravity[2] + pushed[i, 2],
            )
            old = table[state.VX, i], table[state.VY, i], table[state.VZ, i]
            new = old[0] + a[0] * kick, old[1] + a[1] * kick, old[2] + a[2] * kick
            table[state.VX, i], table[state.VY, i], table[state.VZ, i] = new
            table[state.NEW_X, i] = table[state.X, i] + new[0] * dt
            table[state.NEW_X + 1, i] = table[state.Y, i] + new[1] * dt
            table[state.NEW_X + 2, i] = table[state.Z, i] + new[2] * dt
            moved[i, MOVED], moved[i, MOVED + 1], moved[i, MOVED + 2] = new
            gained = total(power_of_stress) + 0.5 * viscosity.heating * total(heat)
            gained += 0.5 * total(against)
            table[state.ENERGY, i] += 0.5 * kick * gained
            px += mass * (total(bx) + pushed[i, 3])
            py += mass * (total(by) + pushed[i, 4])
            pz += mass * (total(bz) + pushed[i, 5])
            weight += mass
            for axis in range(3):
                path = 0.5 * mass * (old[axis] + new[axis]) * kick
                work += gravity[axis] * path
                touched += pushed[i, axis] * path
            length, sound = number(place, i, LENGTH), number(other, i, SOUND)
            signal = sound + VISCOUS * (viscosity.linear * sound + viscosity.quadratic * largest(nearest))
            force = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]) ** 0.25
            fastest = max(fastest, signal / length, force / length**0.5)
    sums[IMPULSE], sums[IMPULSE + 1], sums[IMPULSE + 2] = px * kick, py * kick, pz * kick
    sums[WEIGHT], sums[WORK], sums[FASTEST], sums[TOUCHED] = weight, work, fastest, touched


@kernel
def find_gradients(smoothing, dimensions, tables, table, ranges, lists, correction, gradients, kick, dt):
    """Gradients of the velocities after the kick, into three lines of ``gradients`` (3 n, 8) for each particle.

    The energy takes the other half of the work, but for what the point update adds in a step.
    """
    place, stress, other = bare(tables.place), bare(tables.stress), bare(tables.other)
    tensile = bare(tables.tensile)
    neighbours = bare(lists.neighbours)
    none = spread(0.0)
    for body in range(ranges.shape[0]):
        for i in range(ranges[body, 0], ranges[body, 1]):
            own, others = row(place, i), row(other, i)
            l11 = l12 = l13 = l21 = l22 = l23 = l31 = l32 = l33 = heat = against = none
            for k in range(lists.first[i], lists.stop[i], LANES):
                near, nearby = rows(place, neighbours, k), rows(other, neighbours, k)
                d, squared, length, force, q = apart(dimensions, own, near)
                weighted = near[HEAVY] * force
                gx, gy, gz = weighted * d[0], weighted * d[1], weighted * d[2]
                pressure, _, _ = viscous(smoothing, own, others, near, nearby, d, squared, length)
                vx, vy = others[MOVED] - nearby[MOVED], others[MOVED + 1] - nearby[MOVED + 1]
                vz = others[MOVED + 2] - nearby[MOVED + 2]
                heat = heat + pressure * (vx * gx + vy * gy + vz * gz)
                rx, ry, rz = opposed(smoothing, tensile, i, neighbours, k, q, gx, gy, gz)
                against = against + (vx * rx + vy * ry + vz * rz)
                l11, l12, l13 = l11 - vx * gx, l12 - vx * gy, l13 - vx * gz
                l21, l22, l23 = l21 - vy * gx, l22 - vy * gy, l23 - vy * gz
                l31, l32, l33 = l31 - vz * gx, l32 - vz * gy, l33 - vz * gz
            table[state.ENERGY, i] += 0.25 * kick * smoothing.viscosity.heating * total(heat)
            table[state.ENERGY, i] += 0.25 * kick * total(against)
            over = 1.0 / number(other, i, RHO)
            b11, b22, b33 = (correction[i, 0] * over, correction[i, 1] * over, correction[i, 2] * over)
            b12, b23, b31 = (correction[i, 3] * over, correction[i, 4] * over, correction[i, 5] * over)
            first = total(l11), total(l12), total(l13)
            second = total(l21), total(l22), total(l23)
            third = total(l31), total(l32), total(l33)
            line = 3 * i
            for component, raw in enumerate((first, second, third)):
                gradients[line, 1 + component] = raw[0] * b11 + raw[1] * b12 + raw[2] * b31
                gradients[line + 1, 1 + component] = raw[0] * b12 + raw[1] * b22 + raw[2] * b23
                gradients[line + 2, 1 + component] = raw[0] * b31 + raw[1] * b23 + raw[2] * b33
            power = number(stress, i, 0) * first[0] + number(stress, i, 1) * first[1]
            power += number(stress, i, 2) * first[2] + number(stress, i, 3) * second[0]
            power += number(stress, i, 4) * second[1] + number(stress, i, 5) * second[2]
            power += number(stress, i, 6) * third[0] + number(stress, i, 7) * third[1]
            power += number(other, i, T33) * third[2]
            table[state.ENERGY, i] += 0.5 * (kick - dt) * power


@kernel
def find_forces_of_others(smoothing, dimensions, tables, table, particles, lists, marks, forces):
    """Forces (k, 6) on some particles by what another method moves, N: by all of it, and then by images alone.

    Rows of ``marks`` (n, 8) begin with 1 for what another method moves, and go on with 1 for its images.
    """
    place, stress, other = bare(tables.place), bare(tables.stress), bare(tables.other)
    tensile = bare(tables.tensile)
    neighbours, marks = bare(lists.neighbours), bare(marks)
    none = spread(0.0)
    for at in range(particles.size):
        i = particles[at]
        own, t, others = row(place, i), row(stress, i), row(other, i)
        ax = ay = az = bx = by = bz = none
        for k in range(lists.first[i], lists.stop[i], LANES):
            near, s = rows(place, neighbours, k), rows(stress, neighbours, k)
            nearby, flags = rows(other, neighbours, k), rows(marks, neighbours, k)
            d, squared, length, force, q = apart(dimensions, own, near)
            weighted = near[HEAVY] * force * flags[0]
            gx, gy, gz = weighted * d[0], weighted * d[1], weighted * d[2]
            pressure, _, _ = viscous(smoothing, own, others, near, nearby, d, squared, length)
            fx, fy, fz = pull(t, others[T33], gx, gy, gz)
            sx, sy, sz = pull(s, nearby[T33], gx, gy, gz)
            rx, ry, rz = opposed(smoothing, tensile, i, neighbours, k, q, gx, gy, gz)
            fx, fy, fz = (fx + sx - pressure * gx - rx, fy + sy - pressure * gy - ry, fz + sz - pressure * gz - rz)
            ax, ay, az = ax + fx, ay + fy, az + fz
            bx, by, bz = bx + flags[1] * fx, by + flags[1] * fy, bz + flags[1] * fz
        mass = table[state.MASS, i]
        for component, lanes in enumerate((ax, ay, az, bx, by, bz)):
            forces[at, component] = mass * total(lanes)
