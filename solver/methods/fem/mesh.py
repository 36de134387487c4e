"""Meshes: where their nodes stand, what each node has of the mass of the elements around it, and their end faces."""

import math

import numpy as np

from solver.errors import ProblemError
from solver.methods.fem.elements import CORNERS, NODES, mean_operator
from solver.problem import Mesh, Traction

_CORNERS = np.array(CORNERS)
GAUSS = 1.0 / math.sqrt(3.0)  # place of a point of the rule with two of them, on -1..1


def lattice(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, Mesh]:
    """Nodes (n, 3) at all combinations of ascending coordinates along each axis (m), and the mesh between them."""
    position = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    counts = len(x), len(y), len(z)
    number = np.arange(position.shape[0]).reshape(counts)
    cells = [
        number[tuple(slice(step, count - 1 + step) for step, count in zip(corner, counts, strict=True))]
        for corner in (_CORNERS + 1) // 2
    ]
    return position, Mesh(np.stack([corner.ravel() for corner in cells], axis=-1))


def volumes_of(mesh: Mesh, position: np.ndarray) -> np.ndarray:
    """The volume of each element (e,), m3; raises ProblemError for one that is inside out."""
    x = np.moveaxis(position[mesh.nodes], 0, -1)  # of all elements at once
    volumes: np.ndarray = mean_operator(x, np.zeros_like(x))
    if (volumes <= 0.0).any():
        element = int(np.argmax(volumes <= 0.0))
        raise ProblemError(f"element {element} has no volume; order its nodes as ``problem.Mesh`` says")
    return volumes


def node_parts(mesh: Mesh, position: np.ndarray) -> np.ndarray:
    """The part of each element's volume that each of its nodes has, (e, nodes); rows sum to one.

    That is the integral of the node's shape function by the rule with two points along each axis: Hinton, Rock and
    Zienkiewicz (1976), row-sum lumping.
    """
    near = 1.0 + GAUSS * _CORNERS[:, None, :] * _CORNERS[None, :, :]  # (points, nodes, 3)
    slopes = 0.125 * _CORNERS * near[..., [1, 2, 0]] * near[..., [2, 0, 1]]
    # Rows are the edges along each local axis; their determinant is the point's part of the volume.
    edges = sum(position[mesh.nodes[:, n], None, None, :] * slopes[:, n, :, None] for n in range(NODES))
    (a, b, c), (d, e, f), (g, h, i) = np.moveaxis(np.asarray(edges), (2, 3), (0, 1))
    volumes = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g)
    parts: np.ndarray = np.ascontiguousarray(volumes) @ np.prod(0.5 * near, axis=-1)
    return parts / parts.sum(axis=1, keepdims=True)


def node_masses(mesh: Mesh, position: np.ndarray, density: float) -> np.ndarray:
    """The lumped mass of each node of a mesh of uniform density, (n,), kg."""
    parts = density * volumes_of(mesh, position)[:, None] * node_parts(mesh, position)
    return np.bincount(mesh.nodes.ravel(), parts.ravel(), minlength=len(position))


def end_faces(mesh: Mesh, position: np.ndarray, load: Traction) -> np.ndarray:
    """The faces of elements in the plane end of a body that a traction presses on: (k, 4) nodes, in turn round each."""
    place = position[:, load.axis]
    end = place.max() if load.side else place.min()
    at_end = np.abs(place - end) <= 1e-9 * np.ptp(position, axis=0).max()
    chosen = at_end[mesh.nodes]
    rows = np.flatnonzero(chosen.sum(axis=1) == 4)
    faces = np.array([mesh.nodes[row][chosen[row]] for row in rows]).reshape(-1, 4)
    along = position[faces][:, :, [other for other in range(3) if other != load.axis]]
    away = along - along.mean(axis=1, keepdims=True)
    order = np.argsort(np.arctan2(away[..., 1], away[..., 0]), axis=1)
    ordered: np.ndarray = np.take_along_axis(faces, order, axis=1)
    return ordered


def face_areas(faces: np.ndarray, position: np.ndarray, axis: int) -> np.ndarray:
    """The area along an axis that each node of each face has now, (k, 4), m2, unsigned."""
    place = position[faces]
    first, second = (other for other in range(3) if other != axis)
    diagonal, other = place[:, 2] - place[:, 0], place[:, 3] - place[:, 1]
    area = 0.5 * np.abs(diagonal[:, first] * other[:, second] - diagonal[:, second] * other[:, first])
    return np.repeat(0.25 * area[:, None], 4, axis=1)
