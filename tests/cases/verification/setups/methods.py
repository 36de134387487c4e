"""Columns for the methods beside the grid: a line of smoothed particles, or a bar of hexahedra, one in each cell.

What is asked of them was fixed before any run: plane impact at 2 km/s of both alike, waves and gases about as the grid
is asked.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from solver.audit import Audit
from solver.methods.fem.mesh import lattice, node_masses
from solver.problem import Body, Problem, Smoothing
from solver.problem.geometry import Cartesian3D, grid
from studies.quantities.numerical_defaults import RECIPES, Recipe
from tests.claims.rows import Row, zero

LINE: Recipe = replace(RECIPES["whipple"], particles_per_cell=1)

# The numerics of all cases: Monaghan's viscosity (1, 2), the spline with h = 1.3 spacings, corrected gradients.
SPH = Smoothing()
PLAIN = SPH._replace(corrected=False)
SMOOTHINGS = {"corrected gradients": SPH, "plain gradients": PLAIN}
COURANT = 0.3

COURANT_OF_ELEMENTS = 0.8  # of the bound of each


def smoothed(problem: Problem, smoothing: Smoothing = SPH, **changes: Any) -> Problem:
    """The problem of a column (``column.column``) in one dimension, without sides: masses per area."""
    old = problem.geometry
    geometry = grid(Cartesian3D, lower=old.lower, cells=(int(old.cells[0]), 0, 0), spacing=old.spacing)
    bodies = tuple(
        replace(body, mass=body.mass / (body.spacing[1] * body.spacing[2]), spacing=(body.spacing[0], 1.0, 1.0))
        for body in problem.bodies
    )
    return replace(problem, geometry=geometry, bodies=bodies, smoothing=smoothing, courant=COURANT, **changes)


def meshed(problem: Problem) -> Problem:
    """The problem of a column as a bar of one hexahedron across, between planes of symmetry."""
    bodies = tuple(_bar(body, problem.geometry.spacing) for body in problem.bodies)
    return replace(problem, bodies=bodies, courant=COURANT_OF_ELEMENTS)


def _bar(body: Body, spacing: float) -> Body:
    middles = np.sort(body.position[:, 0])
    step = body.spacing[0]
    planes = np.append(middles - 0.5 * step, middles[-1] + 0.5 * step)
    position, mesh = lattice(planes, np.array([0.0, spacing]), np.array([0.0, spacing]))
    velocity = np.zeros_like(position)
    velocity[:, 0] = np.interp(position[:, 0], body.position[:, 0], body.velocity[:, 0])
    return replace(
        body,
        position=position,
        velocity=velocity,
        mass=node_masses(mesh, position, body.density),
        spacing=(step, spacing, spacing),
        mesh=mesh,
    )


def kept(where: str, audit: Audit, within: float, of_momentum: str = "error of the momentum") -> Iterator[Row]:
    """Energy and momentum to round-off."""
    for name, got in (("drift of the total energy", audit.energy_drift), (of_momentum, audit.momentum_error)):
        yield zero(f"{where}: {name}", got=got, within=within)
