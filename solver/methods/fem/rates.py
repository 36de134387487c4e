"""The forces of elements on their nodes at n, and after them the velocity gradients at n+1.

With the mean operator G of ``elements``, at the one integration point of an element of mass m

    L = v G
    f_I = -m / rho sigma G_I, the adjoint of L

One point does not see the hourglass modes h of its element. Their resistance is that of springs: with
gamma = h - (h . x) G, which vanishes for linear velocities, Q' = K gamma . v and f_I = -Q gamma_I for each mode and
component, Q turning with the matter: Flanagan and Belytschko (1981), Int. J. Numer. Meth. Eng. 17, 679. K makes the
frequency of a mode the root of ``hourglass`` times the bound of the element's own, n M sum(G^2) / rho, with n nodes and
the longitudinal modulus M of the matter at rest. What the springs take is energy removed.
"""

import math
from typing import NamedTuple

import numpy as np

from solver.jit import device, kernel
from solver.matter.tensor import contract, symmetric
from solver.methods.fem.elements import MODES, NODES, mean_operator, strained, thrust
from solver.problem.geometry import AXES
from solver.state import DENSITY, ENERGY, MASS, NEW_X, PRESSURE, VISCOSITY, VX, X
from solver.steps.space import VELOCITY, deviator_of

IMPULSE, HELD, WORK = 0, 3, 4  # of the sums over nodes


class Meshed(NamedTuple):
    """The elements of a body in the tables of the problem, and their operators at n."""

    nodes: np.ndarray  # (e, nodes) columns of the table of particles
    first: int  # column of the first element in the table of states
    stiffness: float  # ``hourglass`` times the longitudinal modulus at rest, Pa
    springs: np.ndarray  # (e, modes, 3) hourglass forces Q, N
    operators: np.ndarray  # (e, nodes, 3) 1/m
    gamma: np.ndarray  # (e, modes, nodes)
    volume: np.ndarray  # (e,) m3
    x: np.ndarray  # (e, nodes, 3) m
    forces: np.ndarray  # (e, nodes, 3) on its nodes, N


def meshed(nodes, first, stiffness, forces):
    """The tables of a body's elements; ``forces`` is memory that all bodies share."""
    elements, modes = nodes.shape[0], len(MODES)
    return Meshed(
        nodes,
        first,
        stiffness,
        springs=np.zeros((elements, modes, AXES)),
        operators=np.zeros((elements, NODES, AXES)),
        gamma=np.zeros((elements, modes, NODES)),
        volume=np.zeros(elements),
        x=np.zeros((elements, NODES, AXES)),
        forces=forces,
    )


@kernel
def find_operators(meshed, table, begin, end):
    """The operators, volumes and hourglass vectors gamma of the elements begin..end."""
    for element in range(begin, end):
        x, operator = meshed.x[element], meshed.operators[element]
        for node in range(NODES):
            for axis in range(AXES):
                x[node, axis] = table[X + axis, meshed.nodes[element, node]]
        meshed.volume[element] = mean_operator(x, operator)
        for number in range(meshed.gamma.shape[1]):
            gamma = meshed.gamma[element, number]
            for node in range(NODES):
                gamma[node] = MODES[number][node]
            for axis in range(AXES):
                away = 0.0
                for node in range(NODES):
                    away += MODES[number][node] * x[node, axis]
                for node in range(NODES):
                    gamma[node] -= away * operator[node, axis]


@device
def flow_of(gamma, v, axis):
    """gamma . v of a component of the velocity."""
    flow = 0.0
    for node in range(v.shape[0]):
        flow += gamma[node] * v[node, axis]
    return flow


@device
def power_of(states, p, rate, heating):
    """Power of the stress of an element in a rate of strain, with a part of its viscosity; W/m3."""
    heated = states[PRESSURE, p] + heating * states[VISCOSITY, p]
    return contract(deviator_of(states, p), rate) - heated * (rate[0] + rate[1] + rate[2])


@kernel
def push_nodes(meshed, table, states, begin, end, kick, heating, v, taken):
    """Forces of the elements begin..end on each of their nodes; ``v`` (nodes, 3) is scratch.

    The energy of each element takes the half of its stress' work in the velocities before the forces, and ``taken``
    (1,) that of the hourglass springs, J.
    """
    for element in range(begin, end):
        force, operator = meshed.forces[element], meshed.operators[element]
        force[:] = 0.0
        p = meshed.first + element
        for node in range(v.shape[0]):
            for axis in range(AXES):
                v[node, axis] = table[VX + axis, meshed.nodes[element, node]]
        shear, pressure = deviator_of(states, p), states[PRESSURE, p] + states[VISCOSITY, p]
        stress = (shear[0] - pressure, shear[1] - pressure, shear[2] - pressure, shear[3], shear[4], shear[5])
        thrust(stress, -states[MASS, p] / states[DENSITY, p], operator, force)
        rate = symmetric(strained(v, operator))
        states[ENERGY, p] += 0.5 * kick * power_of(states, p, rate, heating) / states[DENSITY, p]
        for number in range(meshed.gamma.shape[1]):
            gamma = meshed.gamma[element, number]
            for axis in range(AXES):
                spring = meshed.springs[element, number, axis]
                taken[0] += 0.5 * kick * spring * flow_of(gamma, v, axis)
                for node in range(v.shape[0]):
                    force[node, axis] -= spring * gamma[node]


@kernel
def strain_elements(meshed, table, states, begin, end, kick, dt, heating, v, gradients, lengths, taken):
    """Gradients of the velocities after the kick, into three lines of ``gradients`` for each element.

    Its ``lengths`` (1, elements) are those at n. The springs of hourglass modes take the other half of their power in
    these velocities, and stretch; ``taken`` (1,) counts it.
    """
    for element in range(begin, end):
        p, operator = meshed.first + element, meshed.operators[element]
        squares = 0.0
        for node in range(NODES):
            for axis in range(AXES):
                v[node, axis] = table[VX + axis, meshed.nodes[element, node]]
                squares += operator[node, axis] ** 2
        volume = meshed.volume[element]
        if volume <= 0.0:  # an element that is inside out: the update reports its density
            states[DENSITY, p] = states[MASS, p] / volume
        # A wave of speed c through the element asks for dt < length / c.
        lengths[0, p] = 2.0 / math.sqrt(NODES * squares)
        gradient = strained(v, operator)
        # The update adds the half of the work of dt: the kick's is another where steps change.
        power = power_of(states, p, symmetric(gradient), heating)
        states[ENERGY, p] += 0.5 * (kick - dt) * power / states[DENSITY, p]
        for axis in range(AXES):
            place = speed = 0.0
            for node in range(NODES):
                place += table[NEW_X + axis, meshed.nodes[element, node]]
                speed += v[node, axis]
            states[NEW_X + axis, p] = place / NODES
            states[VX + axis, p] = speed / NODES
            for component in range(AXES):
                gradients[AXES * p + axis, VELOCITY + component] = gradient[component][axis]
        stretch_springs(meshed, element, v, gradient, squares, kick, dt, taken)


@device
def stretch_springs(meshed, element, v, gradient, squares, kick, dt, taken):
    """The hourglass springs of an element, turned by the spin of its gradient and stretched by its velocities."""
    stiffness = meshed.stiffness * meshed.volume[element] * squares / v.shape[0]
    a = 0.5 * dt * (gradient[1][0] - gradient[0][1])  # about axis 3
    b = 0.5 * dt * (gradient[2][1] - gradient[1][2])
    c = 0.5 * dt * (gradient[0][2] - gradient[2][0])
    for number in range(meshed.gamma.shape[1]):
        gamma, spring = meshed.gamma[element, number], meshed.springs[element, number]
        p, q, r = spring[0], spring[1], spring[2]
        flow = flow_of(gamma, v, 0), flow_of(gamma, v, 1), flow_of(gamma, v, 2)
        taken[0] += 0.5 * kick * (p * flow[0] + q * flow[1] + r * flow[2])
        spring[0] = p + c * r - a * q + stiffness * flow[0] * dt
        spring[1] = q + a * p - b * r + stiffness * flow[1] * dt
        spring[2] = r + b * q - c * p + stiffness * flow[2] * dt


@kernel
def move_nodes(around, joints, forces, held, walls, box, loads, drivers, table, begin, end, kick, dt, sums):
    """Velocities after a ``kick`` (s) and positions after a step of the nodes of the joints begin..end.

    Nodes of a joint move as one: their masses, momenta and forces add. ``joints`` (start, nodes) are the nodes of each,
    ``around`` (start, pairs) the rows of ``forces`` (k, 3) of each node. ``held`` (n, 3) 1 stops a component, ``walls``
    (3, 2) faces of the ``box`` (2, 3) stop approach; ``loads`` (n, 3) are external forces, N. A joint with one of the
    ``drivers`` (n,), columns of the table, or -1, moves as it does. ``sums`` gets the impulse of faces (3), the energy
    that walls and the first step of a joint take, and the work of loads.
    """
    start, pairs = around
    first, members = joints
    for joint in range(begin, end):
        for axis in range(AXES):
            mass = momentum = kinetic = force = pushed = 0.0
            for k in range(first[joint], first[joint + 1]):
                i = members[k]
                mass += table[MASS, i]
                own = table[MASS, i] * table[VX + axis, i]
                momentum += own
                kinetic += 0.5 * own * table[VX + axis, i]
                pushed += loads[i, axis]
                for pair in range(start[i], start[i + 1]):
                    force += forces[pairs[pair], axis]
            i = members[first[joint]]
            old = momentum / mass
            free = old + (force + pushed) / mass * kick
            new = 0.0 if held[i, axis] else free
            if walls[axis, 0]:
                new = max(new, (box[0, axis] - table[X + axis, i]) / dt)
            if walls[axis, 1]:
                new = min(new, (box[1, axis] - table[X + axis, i]) / dt)
            if drivers[i] >= 0:
                new = free = table[VX + axis, drivers[i]]
            given = mass * (new - free)
            sums[IMPULSE + axis] += given
            sums[HELD] += kinetic - 0.5 * momentum * old - 0.5 * given * (old + new)
            sums[WORK] += 0.5 * pushed * (old + new) * kick
            for k in range(first[joint], first[joint + 1]):
                i = members[k]
                table[VX + axis, i] = new
                table[NEW_X + axis, i] = table[X + axis, i] + new * dt


@kernel
def show_nodes(around, element_of, part, states, table, begin, end, lowest, highest):
    """Means of rows lowest..highest of the states at the nodes begin..end, by the mass ``part`` (pairs,) of each pair.

    ``around`` (start, pairs) as above; ``element_of`` (pairs,) is the column of the element of a pair.
    """
    start, pairs = around
    for i in range(begin, end):
        mass = 0.0
        for at in range(start[i], start[i + 1]):
            mass += part[pairs[at]]
        for row in range(lowest, highest):
            whole = 0.0
            for at in range(start[i], start[i + 1]):
                pair = pairs[at]
                p = element_of[pair]
                whole += part[pair] * (states[MASS, p] * states[row, p]) / states[MASS, p]
            table[row, i] = whole / (table[MASS, i] if row == ENERGY else mass)
