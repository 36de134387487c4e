"""The methods that compute the steps of a problem: material points on a grid, and what features add.

How to add one: an entry of the group ``whipple.solver.steppers``, a ``StepMethod``. A function imports its stepper: the
kernels of a method are compiled only where a problem asks for it.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from solver.errors import ProblemError
from solver.registry import entries

if TYPE_CHECKING:
    import numpy as np

    from solver.problem import Mesh, Problem
    from solver.steps.method import Method


@dataclass(frozen=True)
class Meshing:
    """What a method with elements makes for a body."""

    # Nodes (n, 3) of a box at ascending coordinates along each axis (m), and the mesh between them.
    box: "Callable[[np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, Mesh]]"
    # Masses (n,) of the nodes of a mesh (kg) by their places (m) and a density (kg/m3).
    node_masses: "Callable[[Mesh, np.ndarray, float], np.ndarray]"


@dataclass(frozen=True)
class StepMethod:
    """A method: the problems that it computes, and the class of its steps."""

    name: str  # as scenarios name it
    serves: Callable[["Problem"], bool]
    stepper: Callable[[], "type[Method]"]
    meshing: Meshing | None = None  # of a method with elements


def _on_grid(problem: "Problem") -> bool:
    return problem.smoothing is None and not any(body.mesh for body in problem.bodies)


def _grid_stepper() -> "type[Method]":
    from solver.grid.step import Stepper

    return Stepper


STEPPER = StepMethod("mpm", _on_grid, _grid_stepper)


def methods() -> Mapping[str, StepMethod]:
    """All methods by name."""
    return entries(__name__, "STEPPER")


def meshing(method: str) -> Meshing:
    """The meshing of a method with elements; raises ProblemError of a method without, or that is not there."""
    there = methods().get(method)
    if there is None or there.meshing is None:
        raise ProblemError(f"{method} is no method with elements here ({', '.join(methods())}); take another method")
    return there.meshing


def stepper_of(problem: "Problem") -> "type[Method]":
    """The class whose steps compute a problem; raises ProblemError where no method that is there does."""
    for method in methods().values():
        if method.serves(problem):
            return method.stepper()
    raise ProblemError(
        f"no method here ({', '.join(methods())}) computes bodies with a mesh, or smoothed particles; add the feature "
        "that does, or ask for material points"
    )
