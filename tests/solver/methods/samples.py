"""Problems of other methods for the tests that all share, each with what it carries."""

from collections.abc import Callable
from typing import Any

from solver.problem import Problem
from tests.solver.methods.test_coupling import bar, pressing
from tests.solver.methods.test_fem import problem_of, squeezing
from tests.solver.methods.test_sph import REPELLING, impact

SHORT: dict[str, Any] = {"fixed_dt": 1e-8, "end_time": 1.2e-6}  # more than two reorderings
# Each with something of its own to carry, above zero in the run.
PROBLEMS: dict[str, tuple[Callable[[], Problem], Callable[[Any], float]]] = {
    "smoothed": (lambda: impact(smoothing=REPELLING, **SHORT), lambda run: run.stepper.before[0]),
    "elements": (lambda: problem_of(squeezing, **SHORT), lambda run: run.stepper.before[0]),
    "coupled": (lambda: bar(pressing, **SHORT), lambda run: run.stepper.elements.before[0]),
}
LONG = {"coupled"}
