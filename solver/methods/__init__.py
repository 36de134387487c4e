"""Methods beside the grid: smoothed particles (``sph``), finite elements (``fem``), and both in one problem."""

from typing import TYPE_CHECKING

from solver.steppers import Meshing, StepMethod

if TYPE_CHECKING:
    import numpy as np

    from solver.problem import Mesh, Problem
    from solver.steps.method import Method


def _smoothed(problem: "Problem") -> bool:
    return problem.smoothing is not None and not any(body.mesh for body in problem.bodies)


def _meshed(problem: "Problem") -> bool:
    return all(body.mesh for body in problem.bodies)


def _coupled(problem: "Problem") -> bool:
    return any(body.mesh for body in problem.bodies) and not _meshed(problem)


def _particles() -> "type[Method]":
    from solver.methods.sph.step import ParticleStepper

    return ParticleStepper


def _elements() -> "type[Method]":
    from solver.methods.fem.step import ElementStepper

    return ElementStepper


def _both() -> "type[Method]":
    from solver.methods.coupling import CoupledStepper

    return CoupledStepper


def _box(x: "np.ndarray", y: "np.ndarray", z: "np.ndarray") -> "tuple[np.ndarray, Mesh]":
    from solver.methods.fem.mesh import lattice

    return lattice(x, y, z)


def _node_masses(mesh: "Mesh", position: "np.ndarray", density: float) -> "np.ndarray":
    from solver.methods.fem.mesh import node_masses

    return node_masses(mesh, position, density)


MESHING = Meshing(_box, _node_masses)
STEPPERS = (
    StepMethod("sph", _smoothed, _particles),
    StepMethod("fem", _meshed, _elements, MESHING),
    StepMethod("sph-fem", _coupled, _both, MESHING),
)
