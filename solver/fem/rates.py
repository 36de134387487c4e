"""The forces of elements on their nodes at n, and after them the velocity gradients at n+1.

With the operators G of ``elements``, the mean one and those of the integration points q of mass m_q

    L_q = v G_q, its trace that of the mean operator where there are several points
    f_I = -sum_q m_q / rho_q sigma_q G_qI, the adjoint of L

One point in each element does not see its hourglass modes h. Their resistance is that of springs: with
gamma = h - (h . x) G, which vanishes for linear velocities, Q' = K gamma . v and f_I = -Q gamma_I for each mode and
component, Q turning with the matter: Flanagan and Belytschko (1981), Int. J. Numer. Meth. Eng. 17, 679. K makes the
frequency of a mode the root of ``hourglass`` times the bound of the element's own, n M sum(G^2) / rho, with n nodes and
the longitudinal modulus M of the matter at rest. What the springs take is energy removed.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from solver.fem.elements import (
    axes,
    mean_operator,
    mode,
    mode_count,
    node_count,
    point_operator,
    strained,
    thrust,
)
from solver.jit import device, kernel
from solver.state import (
    DENSITY,
    ENERGY,
    MASS,
    NEW_X,
    PRESSURE,
    S11,
    S12,
    S22,
    S23,
    S31,
    S33,
    VELOCITY,
    VISCOSITY,
    VX,
    X,
)
from solver.tensor import contract, symmetric

AXES = 3
TAKEN, SLOWEST = range(
    2
)  # of the sums of a share: energy of hourglass springs, J; spacing over least length
IMPULSE, HELD, WORK = 0, 3, 4  # of the sums over nodes


class Scratch(NamedTuple):
    """Scratch of one element: rows are its nodes."""

    x: np.ndarray  # (8, 3) m
    v: np.ndarray  # (8, 3) m/s
    mean: np.ndarray  # (8, 3) the mean operator, 1/m
    operator: np.ndarray  # (8, 3) that of an integration point, 1/m
    force: np.ndarray  # (8, 3) N
    gamma: np.ndarray  # (8,)


def new_scratch():
    """Scratch for one element after another."""
    return Scratch(*(np.zeros((8, AXES)) for _ in range(5)), np.zeros(8))


class Meshed(NamedTuple):
    """The elements of a body in the tables of the problem."""

    kind: Any
    nodes: np.ndarray  # (e, nodes) columns of the table of particles
    first: int  # column of the first integration point in the table of states
    springs: np.ndarray  # (e, modes, 3) hourglass forces Q, N
    stiffness: float  # ``hourglass`` times the longitudinal modulus at rest, Pa


@device
def gather(nodes, element, table, scratch):
    """Positions and velocities of the nodes of an element."""
    for node in range(nodes.shape[1]):
        column = nodes[element, node]
        for axis in range(AXES):
            scratch.x[node, axis] = table[X + axis, column]
            scratch.v[node, axis] = table[VX + axis, column]


@device
def find_gamma(kind, number, scratch):
    """gamma of an hourglass mode, and its product with the velocities, (3,)."""
    a = b = c = p = q = r = 0.0
    for node in range(node_count(kind)):
        sign = mode(kind, number, node)
        a, b = a + sign * scratch.x[node, 0], b + sign * scratch.x[node, 1]
        c += sign * scratch.x[node, 2]
    away = (a, b, c)
    for node in range(node_count(kind)):
        gamma = float(mode(kind, number, node))
        for axis in range(axes(kind)):
            gamma -= away[axis] * scratch.mean[node, axis]
        scratch.gamma[node] = gamma
        p += gamma * scratch.v[node, 0]
        q += gamma * scratch.v[node, 1]
        r += gamma * scratch.v[node, 2]
    return p, q, r


@device
def find_operator(kind, point, scratch):
    """The operator of an integration point, into ``scratch``: the mean one where there is a single point."""
    if kind.points == 1:
        scratch.operator[:] = scratch.mean
    else:
        point_operator(kind, scratch.x, point, scratch.operator)


@device
def find_gradient(kind, scratch):
    """The velocity gradient of an integration point: with the volume change of the whole element."""
    gradient = strained(kind, scratch.v, scratch.operator)
    if kind.points == 1:
        return gradient
    whole = strained(kind, scratch.v, scratch.mean)
    trace = gradient[0][0] + gradient[1][1] + gradient[2][2]
    more = (whole[0][0] + whole[1][1] + whole[2][2] - trace) / 3.0
    return (
        (gradient[0][0] + more, gradient[0][1], gradient[0][2]),
        (gradient[1][0], gradient[1][1] + more, gradient[1][2]),
        (gradient[2][0], gradient[2][1], gradient[2][2] + more),
    )


@kernel
def push_nodes(meshed, table, states, begin, end, dt, heating, scratch, forces, sums):
    """Forces of the elements begin..end on each of their nodes, into ``forces`` (e, nodes, 3).

    The energy of each integration point takes the half of its stress' work in the velocities before the forces.
    """
    kind = meshed.kind
    for element in range(begin, end):
        scratch.force[:] = 0.0
        start = meshed.first + element * kind.points
        if states[MASS, start] > 0.0:
            gather(meshed.nodes, element, table, scratch)
            mean_operator(kind, scratch.x, scratch.mean)
            for point in range(kind.points):
                p = start + point
                find_operator(kind, point, scratch)
                volume = states[MASS, p] / states[DENSITY, p]
                shear = (
                    states[S11, p],
                    states[S22, p],
                    states[S33, p],
                    states[S12, p],
                    states[S23, p],
                    states[S31, p],
                )
                thrust(kind, shear, -volume, scratch.operator, scratch.force)
                pressure = states[PRESSURE, p] + states[VISCOSITY, p]
                isotropic = (pressure, pressure, pressure, 0.0, 0.0, 0.0)
                thrust(kind, isotropic, volume, scratch.mean, scratch.force)
                rate = symmetric(find_gradient(kind, scratch))
                heated = states[PRESSURE, p] + heating * states[VISCOSITY, p]
                power = contract(shear, rate) - heated * (rate[0] + rate[1] + rate[2])
                states[ENERGY, p] += 0.5 * dt * power / states[DENSITY, p]
            if kind.points == 1:
                for number in range(mode_count(kind)):
                    flow = find_gamma(kind, number, scratch)
                    for axis in range(AXES):
                        spring = meshed.springs[element, number, axis]
                        sums[TAKEN] += 0.5 * dt * spring * flow[axis]
                        for node in range(node_count(kind)):
                            scratch.force[node, axis] -= spring * scratch.gamma[node]
        for node in range(node_count(kind)):
            for axis in range(AXES):
                forces[element, node, axis] = scratch.force[node, axis]


@kernel
def strain_elements(meshed, table, states, begin, end, spacing, dt, scratch, gradients, sums):
    """Velocity gradients of the velocities at n+1, into three lines of ``gradients`` for each integration point.

    The springs of hourglass modes act half of their power in these velocities, and stretch.
    """
    kind = meshed.kind
    nodes = node_count(kind)
    for element in range(begin, end):
        start = meshed.first + element * kind.points
        if states[MASS, start] <= 0.0:
            continue
        gather(meshed.nodes, element, table, scratch)
        volume = mean_operator(kind, scratch.x, scratch.mean)
        squares = 0.0
        for node in range(nodes):
            for axis in range(AXES):
                squares += scratch.mean[node, axis] ** 2
        if volume <= 0.0:  # an element that is inside out: the update reports its density
            states[DENSITY, start] = states[MASS, start] / volume
        # A wave of speed c through the element asks for dt < 2 / (c sqrt(n sum(G^2))).
        sums[SLOWEST] = max(sums[SLOWEST], 0.5 * spacing * math.sqrt(nodes * squares))
        for point in range(kind.points):
            p = start + point
            find_operator(kind, point, scratch)
            gradient = find_gradient(kind, scratch)
            for axis in range(AXES):
                place = speed = 0.0
                for node in range(nodes):
                    place += table[NEW_X + axis, meshed.nodes[element, node]]
                    speed += scratch.v[node, axis]
                states[NEW_X + axis, p] = place / nodes
                states[VX + axis, p] = speed / nodes
                for component in range(AXES):
                    gradients[AXES * p + axis, VELOCITY + component] = gradient[component][axis]
        if kind.points > 1:
            continue
        stiffness = meshed.stiffness * volume * squares / nodes
        spin = strained(kind, scratch.v, scratch.mean)
        for number in range(mode_count(kind)):
            flow = find_gamma(kind, number, scratch)
            q0, q1, q2 = (
                meshed.springs[element, number, 0],
                meshed.springs[element, number, 1],
                meshed.springs[element, number, 2],
            )
            sums[TAKEN] += 0.5 * dt * (q0 * flow[0] + q1 * flow[1] + q2 * flow[2])
            a = 0.5 * dt * (spin[1][0] - spin[0][1])  # about axis 3
            b = 0.5 * dt * (spin[2][1] - spin[1][2])
            c = 0.5 * dt * (spin[0][2] - spin[2][0])
            meshed.springs[element, number, 0] = q0 + c * q2 - a * q1 + stiffness * flow[0] * dt
            meshed.springs[element, number, 1] = q1 + a * q0 - b * q2 + stiffness * flow[1] * dt
            meshed.springs[element, number, 2] = q2 + b * q1 - c * q0 + stiffness * flow[2] * dt


@kernel
def move_nodes(around, forces, held, walls, lower, upper, loads, table, begin, end, dt, sums):
    """Velocities at n+1 and new positions of the nodes begin..end: sums of the forces of the elements around each.

    ``around`` is (start, pairs): where the places of a node's forces begin in ``pairs``, and they in ``forces`` (k, 3).
    ``held`` (n, 3) 1 stops a component, ``walls`` (3, 2) faces stop approach; ``loads`` (n, 3) are external forces, N.
    ``sums`` gets the impulse of faces (3), the energy that walls take and the work of loads.
    """
    start, pairs = around
    for i in range(begin, end):
        mass = table[MASS, i]
        for axis in range(AXES):
            force = loads[i, axis]
            for k in range(start[i], start[i + 1]):
                force += forces[pairs[k], axis]
            old = table[VX + axis, i]
            free = old + force / mass * dt
            new = 0.0 if held[i, axis] else free
            if walls[axis, 0]:
                new = max(new, (lower[axis] - table[X + axis, i]) / dt)
            if walls[axis, 1]:
                new = min(new, (upper[axis] - table[X + axis, i]) / dt)
            given = mass * (new - free)
            sums[IMPULSE + axis] += given
            sums[HELD] -= 0.5 * given * (old + new)
            sums[WORK] += 0.5 * loads[i, axis] * (old + new) * dt
            table[VX + axis, i] = new
            table[NEW_X + axis, i] = table[X + axis, i] + new * dt
