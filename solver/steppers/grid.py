"""Material points on a grid."""

from typing import TYPE_CHECKING

from solver.steppers import StepMethod

if TYPE_CHECKING:
    from solver.problem import Problem
    from solver.steps.method import Method


def _serves(problem: "Problem") -> bool:
    return problem.smoothing is None and not any(body.mesh for body in problem.bodies)


def _stepper() -> "type[Method]":
    from solver.grid.step import Stepper

    return Stepper


STEPPER = StepMethod("mpm", _serves, _stepper)
