"""The methods that compute the steps of a problem: material points on a grid, and what features add.

How to add one: an entry of the group ``whipple.solver.steppers``, a ``StepMethod``. It names its stepper, which is
imported, and whose kernels are compiled, only where a problem asks for it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Protocol

from solver.errors import ProblemError
from solver.registry import entries

if TYPE_CHECKING:
    import numpy as np

    from solver.problem import Mesh, Problem
    from solver.steps.method import Method


class Meshing(Protocol):
    """What a method with elements makes for a body."""

    def lattice(self, x: "np.ndarray", y: "np.ndarray", z: "np.ndarray") -> "tuple[np.ndarray, Mesh]":
        """Nodes (n, 3) of a box at ascending coordinates along each axis (m), and the mesh between them."""

    def node_masses(self, mesh: "Mesh", position: "np.ndarray", density: float) -> "np.ndarray":
        """Masses (n,) of the nodes of a mesh (kg) by their places (m) and a density (kg/m3)."""


@dataclass(frozen=True)
class StepMethod:
    """A method: the problems that it computes, and the class of its steps."""

    name: str  # as scenarios name it
    serves: Callable[["Problem"], bool]
    stepper: str  # where the class of its steps is: "solver.grid.step:Stepper"
    meshing: str = ""  # the module that is the ``Meshing`` of a method with elements


STEPPER = StepMethod(
    "mpm",
    lambda problem: problem.smoothing is None and not any(body.mesh for body in problem.bodies),
    "solver.grid.step:Stepper",
)


def methods() -> Mapping[str, StepMethod]:
    """All methods by name."""
    return entries(__name__, "STEPPER")


def meshing(method: str) -> Meshing:
    """The meshing of a method with elements."""
    module: Meshing = resolve_name(methods()[method].meshing)
    return module


def stepper_of(problem: "Problem") -> "type[Method]":
    """The class whose steps compute a problem; raises ProblemError where no method that is there does."""
    for method in methods().values():
        if method.serves(problem):
            stepper: type[Method] = resolve_name(method.stepper)
            return stepper
    raise ProblemError(
        f"no method here ({', '.join(methods())}) computes bodies with a mesh, or smoothed particles; add the feature "
        "that does, or ask for material points"
    )
