"""Strays: particles of debris in a void, whose state has nothing to do with the space around them.

A particle takes the divergence of the grid as if its matter filled the cell. In a cloud that has expanded to a particle
a cell and less, its matter is a thousandth of the space; where heavy debris closes that space again, it is compressed
with the void. Its pressure acts through its own small volume, and so does not stop the others before it exceeds theirs
by the ratio of the volumes. The work is that of the heavy particles, so that the sum of the energies is kept, but one
with 1e-9 of all mass takes 1e9 J/kg. In codes with cells the void closes before its matter is compressed (Benson
1992, Comput. Methods Appl. Mech. Eng. 99, 235).

A stray is discarded once its state is beyond the limits of a physical one: it departs with its mass, momentum and
energy, which the ledger has, and is counted.
"""

import numpy as np

from solver.problem import Problem
from solver.problem.geometry import lattice_measure
from solver.state import Particles

# Part of the space within a cell that matter fills: with less there is a void. At a corner of whole matter it fills a
# quarter in three dimensions.
FILLED = 0.2
# Of the mean mass of the particles within a cell, its own: with less it has no weight beside them. Those of whole
# matter are alike, but for the axis, where the first has a third of the mean.
LIGHT = 0.1
# Mass that a run discards at most, of the initial: what takes more is no stray. The largest outcome that is measured of
# debris, its momentum, is uncertain by more.
MOST_DISCARDED = 1e-4


def strays(problem: Problem, particles: Particles, index: np.ndarray) -> np.ndarray:
    """Whether each of some particles (indices) is a stray, (n,); one whose state is not finite has spoilt others."""
    return np.array([_is_finite(particles, p) and _is_stray(problem, particles, p) for p in index], bool)


def _is_finite(particles: Particles, p: int) -> bool:
    state = particles.position[p].sum() + particles.velocity[p].sum() + particles.energy[p]
    stress = particles.pressure[p] + particles.viscosity[p] + particles.deviator[p].sum()
    return bool(np.isfinite(state + stress + particles.plastic_strain[p] + particles.temperature[p]))


def _is_stray(problem: Problem, particles: Particles, p: int) -> bool:
    """Whether a particle is in a void, or light beside what is within a cell of it along each axis."""
    geometry = problem.geometry
    place = particles.position[p]
    near = particles.mass > 0.0
    for axis in np.flatnonzero(geometry.cells):
        near &= np.abs(particles.position[:, axis] - place[axis]) < geometry.spacing
    mass = particles.mass[near]
    space = lattice_measure(geometry, place, np.full(3, 2.0 * geometry.spacing))
    filled = float((mass / particles.density[near]).sum())
    return bool(filled < FILLED * space or particles.mass[p] < LIGHT * mass.mean())
