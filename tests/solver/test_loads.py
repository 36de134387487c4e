"""Loads: the mean of a table over a step, and tables that are refused."""

from dataclasses import replace

import numpy as np
import pytest

from solver.errors import ProblemError
from solver.loads import mean_pressure
from solver.problem import Traction
from tests.solver.bodies import two_blocks

RAMP = Traction(0, 0, 1, np.array([1.0, 2.0, 4.0]), np.array([0.0, 6.0, 6.0]))


@pytest.mark.parametrize(
    ("begin", "end", "mean"),
    [(0.0, 1.0, 0.0), (1.0, 2.0, 3.0), (0.0, 4.0, 15.0 / 4.0), (3.0, 5.0, 3.0), (4.0, 9.0, 0.0)],
)
def test_pressure__of_a_step_is_the_mean_of_its_table(begin: float, end: float, mean: float) -> None:
    assert mean_pressure(RAMP, begin, end) == pytest.approx(mean, abs=1e-12)


@pytest.mark.parametrize(
    ("time", "pressure", "reason"),
    [
        ([1.0], [1.0], "at least two"),
        ([1.0, 2.0], [1.0], "as many"),
        ([2.0, 1.0], [1.0, 1.0], "ascend"),
        ([1.0, 2.0], [1.0, np.inf], "finite"),
    ],
)
def test_traction__with_a_table_that_is_none_is_refused(time: list[float], pressure: list[float], reason: str) -> None:
    load = RAMP._replace(time=np.array(time), pressure=np.array(pressure))
    with pytest.raises(ProblemError, match=reason):
        replace(two_blocks("axisymmetric"), tractions=(load,))
