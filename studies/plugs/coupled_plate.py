"""A plate of smoothed particles in its centre and hexahedra around them: Zhang, Qiang and Gao (2011), section 3.2.

The plate is square and this its quarter: x, y > 0, the faces at two places along z. Particles stand on a lattice of
whole spacings in a square about the axis, those on its faces with a half of a particle's mass, as nodes would. The
elements lie in rings from there to the rim; the nodes of the innermost ring are the places of the outermost particles.
"""

from typing import TYPE_CHECKING

from solver.steppers import meshing

if TYPE_CHECKING:
    from solver.matter.laws import Matter
    from solver.problem import Body

# The rings that particles see, within two smoothing lengths, are as wide as a spacing; each farther ring is wider by
# GROWTH, up to the thickness of the plate. Hourglass springs of elements of that width stiffen its bending by a fifth;
# this grows with the square of the width.
EVEN, GROWTH = 3, 1.25


def coupled_plate(
    name: str, matter: "Matter", *, square: float, width: float, begin: float, end: float, step: float, density: float
) -> tuple["Body", "Body"]:
    """Elements and particles of a plate; ``square`` and ``width`` are half the sides of both, ``step`` a spacing, m."""
    import numpy as np

    from solver.problem import Body

    make = meshing("sph-fem")
    across, along = _pieces(square, end - begin, step)
    widths = _ring_widths(width - square, end - begin, square / across)
    line = np.linspace(0.0, square, across + 1)
    heights = np.linspace(begin, end, along + 1)
    spacing = (square / across, square / across, (end - begin) / along)
    place, inner = make.lattice(line, line, heights)
    # The edge of the square from one plane of symmetry to the other, and where each of its nodes goes in each ring.
    edge = np.concatenate(
        [
            np.stack([np.full(across + 1, square), line], axis=1),
            np.stack([line[-2::-1], np.full(across, square)], axis=1),
        ]
    )
    outwards = np.concatenate([[0.0], np.cumsum(widths)]) / square
    index, outer = make.lattice(np.arange(len(widths) + 1.0), np.arange(len(edge) * 1.0), heights)
    ring, node = index[:, :2].astype(int).T
    rim = np.column_stack([edge[node] * (1.0 + outwards[ring])[:, None], index[:, 2]])
    parts = ((f"{name}-elements", rim, outer), (name, place, inner))
    elements, particles = (
        Body(
            name=body,
            matter=matter,
            position=position,
            velocity=np.zeros(3),
            mass=make.node_masses(own, position, density),
            density=density,
            spacing=spacing,
            mesh=own if body != name else None,
        )
        for body, position, own in parts
    )
    return elements, particles


def plate_size(*, square: float, width: float, thickness: float, step: float) -> int:
    """Particles and nodes of such a plate."""
    across, along = _pieces(square, thickness, step)
    rings = len(_ring_widths(width - square, thickness, square / across))
    return ((across + 1) ** 2 + (rings + 1) * (2 * across + 1)) * (along + 1)


def _pieces(square: float, thickness: float, step: float) -> tuple[int, int]:
    """Spacings along the square and through the plate."""
    return max(1, round(square / step)), max(1, round(thickness / step))


def _ring_widths(distance: float, widest: float, spacing: float) -> list[float]:
    """Widths of the rings of elements that fill a distance, m; the wider ones are stretched alike to its end."""
    wider: list[float] = []
    rest = distance - EVEN * spacing
    while (following := min((wider[-1] if wider else spacing) * GROWTH, max(widest, spacing))) <= rest - sum(
        wider
    ) or not wider:
        wider.append(following)
    stretch = rest / sum(wider)
    return [spacing] * EVEN + [width * stretch for width in wider]
