"""The kinds of element: the gradient operators of each, from the positions of its nodes.

A velocity gradient of an element is L_jk = sum_I v_Ij G_Ik, with the operator G (nodes, 3) in 1/m. Of a body of
revolution the third column is that of the hoop: v_r / r. The mean operator is the mean over the volume of the element,
in closed form: the sum over all elements at a node of V sigma G then vanishes for a uniform stress, however skewed the
elements are (the patch test), and so do hourglass forces in linear velocities.
"""

import math
from typing import NamedTuple

from solver.jit import device, generic, gives, implements

GAUSS = 1.0 / math.sqrt(3.0)  # place of a point of the rule with two of them, on -1..1


class Hexahedron(NamedTuple):
    """Eight nodes in a box: 0 to 3 around the lower face in the sense of rotation x to y, 4 to 7 above them."""

    points: int = 1  # integration points: 1 or 8


class Quadrilateral(NamedTuple):
    """Four nodes of a body of revolution, in the sense of rotation r to z; volumes are per radian."""

    points: int = 1  # integration points: 1 or 4


@generic
def node_count(kind):
    """Nodes of an element."""


@generic
def axes(kind):
    """Axes along which an element has extent."""


@generic
def mode_count(kind):
    """Hourglass modes of an element: patterns of its nodes that the mean operator does not see."""


@generic
def mode(kind, number, node):
    """1 or -1: an hourglass mode at a node."""


@generic
def mean_operator(kind, x, operator):
    """Write the mean of G into ``operator`` (nodes, 3); returns the volume, m3. ``x`` (nodes, 3) are the nodes, m."""


@generic
def point_operator(kind, x, point, operator):
    """Write G at an integration point of the full rule; returns its part of the volume, m3."""


@generic
def strained(kind, v, operator):
    """The velocity gradient of nodes with velocities ``v`` (nodes, 3): three rows, 1/s."""


@generic
def dilation(kind, v, operator, node):
    """The part of a node in the third diagonal component of a velocity gradient, 1/s."""


@generic
def thrust(kind, stress, factor, operator, force):
    """Add a factor (m3) times stress (6 components) times an operator to the forces of nodes (nodes, 3), N."""


# ---- hexahedra -----------------------------------------------------------------------------------

# Coordinates of the nodes on -1..1, and the order in which the formula of node 0 takes the nodes for each other node.
_CORNERS = ((-1, -1, -1), (1, -1, -1), (1, 1, -1), (-1, 1, -1), (-1, -1, 1), (1, -1, 1), (1, 1, 1), (-1, 1, 1))
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
_MODES = (
    (1, 1, -1, -1, -1, -1, 1, 1),
    (1, -1, -1, 1, -1, 1, 1, -1),
    (1, -1, 1, -1, 1, -1, 1, -1),
    (-1, 1, -1, 1, 1, -1, 1, -1),
)


gives(node_count, Hexahedron, 8)
gives(axes, Hexahedron, 3)
gives(mode_count, Hexahedron, 4)


@implements(mode, Hexahedron)
def mode_of_hexahedron(kind, number, node):
    return _MODES[number][node]


@implements(mean_operator, Hexahedron)
def mean_operator_of_hexahedron(kind, x, operator):
    volume = 0.0
    for axis in range(3):
        y, z = (axis + 1) % 3, (axis + 2) % 3
        for node in range(8):
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
    for node in range(8):
        for axis in range(3):
            operator[node, axis] /= volume
    return volume


@implements(point_operator, Hexahedron)
def point_operator_of_hexahedron(kind, x, point, operator):
    corner = _CORNERS[point]
    u, v, w = GAUSS * corner[0], GAUSS * corner[1], GAUSS * corner[2]
    for node in range(8):
        p, q, r = _CORNERS[node]
        operator[node, 0] = 0.125 * p * (1.0 + q * v) * (1.0 + r * w)
        operator[node, 1] = 0.125 * q * (1.0 + r * w) * (1.0 + p * u)
        operator[node, 2] = 0.125 * r * (1.0 + p * u) * (1.0 + q * v)
    a, b, c = _column(x, operator, 0)
    d, e, f = _column(x, operator, 1)
    g, h, i = _column(x, operator, 2)
    # Rows are the edges along each local axis; their inverse takes local slopes to those in space.
    volume = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    for node in range(8):
        s, t, r = operator[node, 0], operator[node, 1], operator[node, 2]
        operator[node, 0] = ((e * i - f * h) * s + (c * h - b * i) * t + (b * f - c * e) * r) / volume
        operator[node, 1] = ((f * g - d * i) * s + (a * i - c * g) * t + (c * d - a * f) * r) / volume
        operator[node, 2] = ((d * h - e * g) * s + (b * g - a * h) * t + (a * e - b * d) * r) / volume
    return volume


@implements(strained, Hexahedron)
def strained_of_hexahedron(kind, v, operator):
    a = b = c = d = e = f = g = h = i = 0.0
    for node in range(8):
        p, q, r = operator[node, 0], operator[node, 1], operator[node, 2]
        a, b, c = a + v[node, 0] * p, b + v[node, 0] * q, c + v[node, 0] * r
        d, e, f = d + v[node, 1] * p, e + v[node, 1] * q, f + v[node, 1] * r
        g, h, i = g + v[node, 2] * p, h + v[node, 2] * q, i + v[node, 2] * r
    return ((a, b, c), (d, e, f), (g, h, i))


@implements(dilation, Hexahedron)
def dilation_of_hexahedron(kind, v, operator, node):
    return v[node, 2] * operator[node, 2]


@implements(thrust, Hexahedron)
def thrust_of_hexahedron(kind, stress, factor, operator, force):
    s11, s22, s33, s12, s23, s31 = stress
    for node in range(8):
        p, q, r = factor * operator[node, 0], factor * operator[node, 1], factor * operator[node, 2]
        force[node, 0] += s11 * p + s12 * q + s31 * r
        force[node, 1] += s12 * p + s22 * q + s23 * r
        force[node, 2] += s31 * p + s23 * q + s33 * r


@device
def _column(x, operator, local):
    """sum_I x_I dN_I / d xi of a local axis, (3,)."""
    first = second = third = 0.0
    for node in range(8):
        first += x[node, 0] * operator[node, local]
        second += x[node, 1] * operator[node, local]
        third += x[node, 2] * operator[node, local]
    return first, second, third


# ---- quadrilaterals of revolution ----------------------------------------------------------------

_SQUARE = ((-1, -1), (1, -1), (1, 1), (-1, 1))
_MODE = (1, -1, 1, -1)


gives(node_count, Quadrilateral, 4)
gives(axes, Quadrilateral, 2)
gives(mode_count, Quadrilateral, 1)


@implements(mode, Quadrilateral)
def mode_of_quadrilateral(kind, number, node):
    return _MODE[node]


@implements(mean_operator, Quadrilateral)
def mean_operator_of_quadrilateral(kind, x, operator):
    """Integrals of r dN/dr, r dN/dz and N over the area: two points an axis integrate them exactly."""
    volume = 0.0
    operator[:] = 0.0
    for point in range(4):
        slopes, values, jacobian, radius = _square(x, point)
        volume += jacobian * radius
        for node in range(4):
            operator[node, 0] += jacobian * radius * slopes[node][0]
            operator[node, 1] += jacobian * radius * slopes[node][1]
            operator[node, 2] += jacobian * values[node]
    for node in range(4):
        for axis in range(3):
            operator[node, axis] /= volume
    return volume


@implements(point_operator, Quadrilateral)
def point_operator_of_quadrilateral(kind, x, point, operator):
    slopes, values, jacobian, radius = _square(x, point)
    for node in range(4):
        operator[node, 0], operator[node, 1] = slopes[node]
        operator[node, 2] = values[node] / radius
    return jacobian * radius


@implements(strained, Quadrilateral)
def strained_of_quadrilateral(kind, v, operator):
    a = b = d = e = i = 0.0
    for node in range(4):
        p, q = operator[node, 0], operator[node, 1]
        a, b = a + v[node, 0] * p, b + v[node, 0] * q
        d, e = d + v[node, 1] * p, e + v[node, 1] * q
        i += v[node, 0] * operator[node, 2]
    return ((a, b, 0.0), (d, e, 0.0), (0.0, 0.0, i))


@implements(dilation, Quadrilateral)
def dilation_of_quadrilateral(kind, v, operator, node):
    return v[node, 0] * operator[node, 2]


@implements(thrust, Quadrilateral)
def thrust_of_quadrilateral(kind, stress, factor, operator, force):
    s11, s22, s33, s12, _, _ = stress
    for node in range(4):
        p, q, r = factor * operator[node, 0], factor * operator[node, 1], factor * operator[node, 2]
        force[node, 0] += s11 * p + s12 * q + s33 * r
        force[node, 1] += s12 * p + s22 * q


@device
def _square(x, point):
    """Slopes (4 nodes of 2, 1/m) and values (4) of the nodes at a point of the full rule, area (m2) and radius (m)."""
    u, v = GAUSS * _SQUARE[point][0], GAUSS * _SQUARE[point][1]
    values = (
        0.25 * (1.0 - u) * (1.0 - v),
        0.25 * (1.0 + u) * (1.0 - v),
        0.25 * (1.0 + u) * (1.0 + v),
        0.25 * (1.0 - u) * (1.0 + v),
    )
    along = (-0.25 * (1.0 - v), 0.25 * (1.0 - v), 0.25 * (1.0 + v), -0.25 * (1.0 + v))
    across = (-0.25 * (1.0 - u), -0.25 * (1.0 + u), 0.25 * (1.0 + u), 0.25 * (1.0 - u))
    a = b = c = d = radius = 0.0
    for node in range(4):
        a += x[node, 0] * along[node]
        b += x[node, 1] * along[node]
        c += x[node, 0] * across[node]
        d += x[node, 1] * across[node]
        radius += x[node, 0] * values[node]
    area = a * d - b * c
    return (
        (
            ((d * along[0] - b * across[0]) / area, (a * across[0] - c * along[0]) / area),
            ((d * along[1] - b * across[1]) / area, (a * across[1] - c * along[1]) / area),
            ((d * along[2] - b * across[2]) / area, (a * across[2] - c * along[2]) / area),
            ((d * along[3] - b * across[3]) / area, (a * across[3] - c * along[3]) / area),
        ),
        values,
        area,
        radius,
    )
