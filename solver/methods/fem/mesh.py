"""Meshes: where their nodes stand, what each node has of the mass of the elements around it, and their end faces."""

import numpy as np

from solver.errors import ProblemError
from solver.methods.fem.elements import CORNERS, GAUSS, NODES, mean_operator, point_operator
from solver.problem import Mesh, Traction

_CORNERS = np.array(CORNERS)


def lattice(x: np.ndarray, y: np.ndarray, z: np.ndarray, *, points: int = 1) -> tuple[np.ndarray, Mesh]:
    """Nodes (n, 3) at all combinations of ascending coordinates along each axis (m), and the mesh between them."""
    position = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    counts = len(x), len(y), len(z)
    number = np.arange(position.shape[0]).reshape(counts)
    cells = [
        number[tuple(slice(step, count - 1 + step) for step, count in zip(corner, counts, strict=True))]
        for corner in (_CORNERS + 1) // 2
    ]
    return position, Mesh(np.stack([corner.ravel() for corner in cells], axis=-1), points)


def point_volumes(mesh: Mesh, position: np.ndarray) -> np.ndarray:
    """The volume of each integration point, (e, points), m3; raises ProblemError for an element that is inside out."""
    x = np.moveaxis(position[mesh.nodes], 0, -1)  # of all elements at once
    operator = np.zeros_like(x)
    if mesh.points == 1:
        volumes = [mean_operator(x, operator)]
    else:
        volumes = [point_operator(x, point, operator) for point in range(mesh.points)]
    found = np.stack(volumes, axis=-1)
    if (found <= 0.0).any():
        element = int(np.argwhere(found <= 0.0)[0, 0])
        raise ProblemError(f"element {element} has no volume; order its nodes as ``problem.Mesh`` says")
    return found


def node_parts(mesh: Mesh, position: np.ndarray) -> np.ndarray:
    """The part of each element's volume that each of its nodes has, (e, nodes); rows sum to one.

    That is the integral of the node's shape function: Hinton, Rock and Zienkiewicz (1976), row-sum lumping.
    """
    # (points, nodes): the shape function of each node at each point of the full rule.
    values = np.prod(0.5 * (1.0 + GAUSS * _CORNERS[:, None, :] * _CORNERS[None, :, :]), axis=-1)
    volumes: np.ndarray = point_volumes(mesh._replace(points=NODES), position) @ values
    return volumes / volumes.sum(axis=1, keepdims=True)


def node_masses(mesh: Mesh, position: np.ndarray, density: float) -> np.ndarray:
    """The lumped mass of each node of a mesh of uniform density, (n,), kg."""
    whole = density * point_volumes(mesh, position).sum(axis=1)
    parts = whole[:, None] * node_parts(mesh, position)
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
