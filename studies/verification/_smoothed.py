"""Columns of the exact problems for smoothed particles: a line of them, one in each cell, without sides."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from solver.geometry import grid
from solver.geometry.cartesian3d import Cartesian3D
from solver.problem import Problem, Smoothing
from solver.sph.smoothing import CubicSpline
from studies.values.recipes import Recipe
from studies.verification import DEFAULT, Row, observed_order, reported

# The numerics of all cases: Monaghan's viscosity (1, 2), the spline with h = 1.3 spacings, corrected gradients.
SPH = Smoothing(CubicSpline())
PLAIN = SPH._replace(corrected=False)
SMOOTHINGS = {"corrected gradients": SPH, "plain gradients": PLAIN}
COURANT = 0.3

LINE: Recipe = replace(DEFAULT, particles_per_cell=1)


def smoothed(problem: Problem, smoothing: Smoothing = SPH, **changes: Any) -> Problem:
    """The problem of a column (``_column.column``) in one dimension: masses per area."""
    old = problem.geometry
    geometry = grid(Cartesian3D, lower=old.lower, cells=(int(old.cells[0]), 0, 0), spacing=old.spacing)
    bodies = tuple(
        replace(body, mass=body.mass / (body.spacing[1] * body.spacing[2]), spacing=(body.spacing[0], 1.0, 1.0))
        for body in problem.bodies
    )
    return replace(problem, geometry=geometry, bodies=bodies, smoothing=smoothing, courant=COURANT, **changes)


def trend(claim: str, errors: Sequence[float]) -> Row:
    """A reported row of the error with the finest spacing and its observed order; 0 over 0 has none."""
    order = observed_order(errors)
    return reported(claim, errors[-1], order=None if math.isnan(order) else order)
