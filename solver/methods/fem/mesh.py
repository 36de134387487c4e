"""Meshes: where their nodes stand, what each node has of the mass of the elements around it, and their end faces."""

from typing import Any

import numpy as np

from solver.errors import ProblemError
from solver.methods.fem.elements import GAUSS, Hexahedron, axes, mean_operator, node_count, point_operator
from solver.problem import Mesh, Traction

_SQUARE = np.array([(0, 0), (1, 0), (1, 1), (0, 1)])
# (nodes, axes) of an element with so many axes, 0 at its lower and 1 at its upper side along each.
_CORNERS = {2: _SQUARE, 3: np.array([(*corner, level) for level in (0, 1) for corner in _SQUARE])}


def lattice(kind: Any, *coordinates: np.ndarray) -> tuple[np.ndarray, Mesh]:
    """Nodes (n, 3) at all combinations of ascending coordinates along each axis (m), and the mesh between them."""
    extent = axes(kind)
    if len(coordinates) != extent:
        raise ProblemError(f"a mesh of {type(kind).__name__} has {extent} axes of coordinates")
    counts = [len(along) for along in coordinates]
    position = np.zeros((int(np.prod(counts)), 3))
    position[:, :extent] = np.stack(np.meshgrid(*coordinates, indexing="ij"), axis=-1).reshape(-1, extent)
    number = np.arange(position.shape[0]).reshape(counts)
    cells = [
        number[tuple(slice(step, count - 1 + step) for step, count in zip(corner, counts, strict=True))]
        for corner in _CORNERS[extent]
    ]
    return position, Mesh(kind, np.stack([corner.ravel() for corner in cells], axis=-1))


def point_volumes(mesh: Mesh, position: np.ndarray) -> np.ndarray:
    """The volume of each integration point, (e, points), m3 (m3 per radian of a body of revolution).

    Raises ProblemError for an element that is inside out.
    """
    kind = mesh.kind
    x = np.moveaxis(position[mesh.nodes], 0, -1)  # of all elements at once
    operator = np.zeros_like(x)
    if kind.points == 1:
        volumes = [mean_operator(kind, x, operator)]
    else:
        volumes = [point_operator(kind, x, point, operator) for point in range(kind.points)]
    found = np.stack(volumes, axis=-1)
    if (found <= 0.0).any():
        element = int(np.argwhere(found <= 0.0)[0, 0])
        raise ProblemError(f"element {element} has no volume; order its nodes as {type(kind).__name__} says")
    return found


def node_parts(mesh: Mesh, position: np.ndarray) -> np.ndarray:
    """The part of each element's volume that each of its nodes has, (e, nodes); rows sum to one.

    That is the integral of the node's shape function: Hinton, Rock and Zienkiewicz (1976), row-sum lumping.
    """
    kind = mesh.kind
    full = type(kind)(points=node_count(kind))
    corners = 2.0 * _CORNERS[axes(kind)] - 1.0
    # (points, nodes): the shape function of each node at each point of the full rule.
    values = np.prod(0.5 * (1.0 + GAUSS * corners[:, None, :] * corners[None, :, :]), axis=-1)
    parts = point_volumes(Mesh(full, mesh.nodes), position)
    volumes: np.ndarray = parts @ values
    return volumes / volumes.sum(axis=1, keepdims=True)


def node_masses(mesh: Mesh, position: np.ndarray, density: float) -> np.ndarray:
    """The lumped mass of each node of a mesh of uniform density, (n,), kg (per radian of a body of revolution)."""
    whole = density * point_volumes(mesh, position).sum(axis=1)
    return np.bincount(
        mesh.nodes.ravel(), (whole[:, None] * node_parts(mesh, position)).ravel(), minlength=len(position)
    )


def end_faces(mesh: Mesh, position: np.ndarray, load: Traction) -> np.ndarray:
    """The faces of elements in the plane end of a body, (k, nodes of a face): what a traction presses on."""
    place = position[:, load.axis]
    end = place.max() if load.side else place.min()
    at_end = np.abs(place - end) <= 1e-9 * np.ptp(position, axis=0).max()
    chosen = at_end[mesh.nodes]
    half = node_count(mesh.kind) // 2
    rows = np.flatnonzero(chosen.sum(axis=1) == half)
    faces = np.array([mesh.nodes[row][chosen[row]] for row in rows]).reshape(-1, half)
    if isinstance(mesh.kind, Hexahedron):
        faces = _ordered(faces, position, load.axis)
    return faces


def _ordered(faces: np.ndarray, position: np.ndarray, axis: int) -> np.ndarray:
    """The nodes of each plane face in the order around it."""
    along = [other for other in range(3) if other != axis]
    place = position[faces][:, :, along]
    away = place - place.mean(axis=1, keepdims=True)
    order = np.argsort(np.arctan2(away[..., 1], away[..., 0]), axis=1)
    ordered: np.ndarray = np.take_along_axis(faces, order, axis=1)
    return ordered


def face_areas(kind: Any, faces: np.ndarray, position: np.ndarray, axis: int) -> np.ndarray:
    """The area along an axis that each node of each face has now, (k, nodes of a face), m2 (per radian), unsigned."""
    place = position[faces]
    if isinstance(kind, Hexahedron):
        first, second = (other for other in range(3) if other != axis)
        diagonal, other = place[:, 2] - place[:, 0], place[:, 3] - place[:, 1]
        area = 0.5 * np.abs(diagonal[:, first] * other[:, second] - diagonal[:, second] * other[:, first])
        return np.repeat(0.25 * area[:, None], 4, axis=1)
    radius, length = place[:, :, 0], np.abs(np.diff(place[:, :, 1 - axis], axis=1))
    # The integral of N r over an edge, r linear along it.
    areas: np.ndarray = length * (2.0 * radius + radius[:, ::-1]) / 6.0
    return areas
