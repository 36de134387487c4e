"""Lattices of particles, and a body of them."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

    from solver.problem import Body, Matter


def line(begin: float, end: float, step: float) -> tuple["np.ndarray", float]:
    """Points in the middle of equal pieces that fill begin..end, and the piece nearest to ``step``."""
    import numpy as np

    pieces = max(1, round((end - begin) / step))
    piece = (end - begin) / pieces
    return begin + piece * (np.arange(pieces) + 0.5), piece


def points(*lines: "np.ndarray") -> "np.ndarray":
    """All points of the lattice that lines along the axes span, (n, axes); the last axis fastest."""
    import numpy as np

    return np.stack([axis.ravel() for axis in np.meshgrid(*lines, indexing="ij")], axis=-1)


def body(
    name: str,
    matter: "Matter",
    geometry: Any,
    *,
    position: "np.ndarray",
    spacing: tuple[float, float, float],
    velocity: "np.ndarray",
    density: float,
    volume: float,
) -> "Body":
    """A body of lattice points (n, 3) whose masses add up to that of ``volume`` (m3, or m3 per radian)."""
    import numpy as np

    from solver.geometry import lattice_measure
    from solver.problem import Body

    measure = np.ones(position.shape[0]) * lattice_measure(geometry, position.T, spacing)
    return Body(
        name=name,
        matter=matter,
        position=position,
        velocity=velocity,
        mass=measure * (density * volume / measure.sum()),
        density=density,
        spacing=spacing,
    )
