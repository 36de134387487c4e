"""The implicit equation of opening voids: its root, for any tension, time step and power."""

import math

from hypothesis import given
from hypothesis import strategies as st

from solver.matter.failure.void_growth import _root

ROUND_OFF = 1e-12
logarithms = st.floats(-8.0, 8.0)


@given(logarithms, logarithms, st.floats(1.0, 20.0))
def test_root__solves_the_equation_to_round_off(factor: float, total: float, power: float) -> None:
    x = _root(10.0**factor, power, 10.0**total)
    assert math.isclose(x + 10.0**factor * x**power, 10.0**total, rel_tol=ROUND_OFF)


def test_root__is_zero_without_tension() -> None:
    assert _root(1.0, 3.0, 0.0) == 0.0
