"""Methods beside the grid: smoothed particles (``sph``), finite elements (``fem``), and both in one problem."""

from typing import TYPE_CHECKING

from solver.steppers import StepMethod

if TYPE_CHECKING:
    from solver.problem import Problem

MESHING = "solver.methods.fem.mesh"


def _smoothed(problem: "Problem") -> bool:
    return problem.smoothing is not None and not any(body.mesh for body in problem.bodies)


def _meshed(problem: "Problem") -> bool:
    return all(body.mesh for body in problem.bodies)


def _coupled(problem: "Problem") -> bool:
    return any(body.mesh for body in problem.bodies) and not _meshed(problem)


STEPPERS = (
    StepMethod("sph", _smoothed, "solver.methods.sph.step:ParticleStepper"),
    StepMethod("fem", _meshed, "solver.methods.fem.step:ElementStepper", MESHING),
    StepMethod("sph-fem", _coupled, "solver.methods.coupling:CoupledStepper", MESHING),
)
