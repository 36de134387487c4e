"""Hexahedra: their gradient operators, from the positions of their nodes.

A velocity gradient of an element is L_jk = sum_I v_Ij G_Ik, with the operator G (nodes, 3) in 1/m. The mean operator is
the mean over the volume of the element, in closed form: the sum over all elements at a node of V sigma G then vanishes
for a uniform stress, however skewed the elements are (the patch test), and so do hourglass forces in linear velocities.
"""

from solver.jit import device

NODES = 8

# Coordinates of the nodes on -1..1, and the order in which the formula of node 0 takes the nodes for each other node.
CORNERS = ((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1))
_AROUND = (
    (1, 2, 3, 4, 5, 7),
    (2, 3, 0, 5, 6, 4),
    (3, 0, 1, 6, 7, 5),
    (0, 1, 2, 7, 4, 6),
    (7, 6, 5, 0, 3, 1),
    (4, 7, 6, 1, 0, 2),
    (5, 4, 7, 2, 1, 3),
    (6, 5, 4, 3, 2, 0),
)
# Hourglass modes: patterns of the nodes that the mean operator does not see.
MODES = (
    (1, 1, -1, -1, -1, -1, 1, 1),
    (1, -1, -1, 1, -1, 1, 1, -1),
    (1, -1, 1, -1, 1, -1, 1, -1),
    (-1, 1, -1, 1, 1, -1, 1, -1),
)


@device
def mean_operator(x, operator):
    """Write the mean of G into ``operator`` (nodes, 3); returns the volume, m3. ``x`` (nodes, 3) are the nodes, m."""
    volume = 0.0
    for axis in range(3):
        y, z = (axis + 1) % 3, (axis + 2) % 3
        for node in range(NODES):
            a, b, c, d, e, f = _AROUND[node]
            # dV / dx of the node: Flanagan and Belytschko (1981), Int. J. Numer. Meth. Eng. 17, 679.
            operator[node, axis] = (
                x[a, y] * ((x[e, z] - x[b, z]) - (x[c, z] - x[d, z]))
                + x[b, y] * (x[a, z] - x[c, z])
                + x[c, y] * ((x[b, z] - x[f, z]) - (x[d, z] - x[a, z]))
                + x[d, y] * ((x[f, z] - x[e, z]) - (x[a, z] - x[c, z]))
                + x[e, y] * (x[d, z] - x[a, z])
                + x[f, y] * (x[c, z] - x[d, z])
            ) * (1.0 / 12.0)
            if axis == 0:
                volume += x[node, 0] * operator[node, 0]
    for node in range(NODES):
        for axis in range(3):
            operator[node, axis] /= volume
    return volume


@device
def strained(v, operator):
    """The velocity gradient of nodes with velocities ``v`` (nodes, 3): three rows, 1/s."""
    a = b = c = d = e = f = g = h = i = 0.0
    for node in range(NODES):
        p, q, r = operator[node, 0], operator[node, 1], operator[node, 2]
        a, b, c = a + v[node, 0] * p, b + v[node, 0] * q, c + v[node, 0] * r
        d, e, f = d + v[node, 1] * p, e + v[node, 1] * q, f + v[node, 1] * r
        g, h, i = g + v[node, 2] * p, h + v[node, 2] * q, i + v[node, 2] * r
    return ((a, b, c), (d, e, f), (g, h, i))


@device
def thrust(stress, factor, operator, force):
    """Add a factor (m3) times stress (6 components) times an operator to the forces of nodes (nodes, 3), N."""
    s11, s22, s33, s12, s23, s31 = stress
    for node in range(NODES):
        p, q, r = factor * operator[node, 0], factor * operator[node, 1], factor * operator[node, 2]
        force[node, 0] += s11 * p + s12 * q + s31 * r
        force[node, 1] += s12 * p + s22 * q + s23 * r
        force[node, 2] += s31 * p + s23 * q + s33 * r
