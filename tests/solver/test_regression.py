"""The same input gives the same numbers, or ``PHYSICS_VERSION`` says that it no longer does."""

import json
import math

import pytest

from solver import PHYSICS_VERSION
from tests.solver.regression import CASES, FILE, numbers

# Other processors and compilers round sums of thousands of terms in another way; sixty steps leave less than this.
RELATIVE = 1e-9
CURE = "refresh tests/solver/regression.json by `python -m tests.solver.regression` and say in the commit which, why"
STORED = json.loads(FILE.read_text(encoding="utf-8"))


def test_regression__numbers_belong_to_this_physics_version() -> None:
    assert STORED["physics_version"] == PHYSICS_VERSION, (
        f"the stored numbers are of physics version {STORED['physics_version']}, "
        f"the solver is {PHYSICS_VERSION}: {CURE}"
    )


def test_regression__has_numbers_of_every_case() -> None:
    assert set(STORED["cases"]) == set(CASES), CURE


@pytest.mark.parametrize("case", list(CASES))
def test_regression__same_input_gives_the_same_numbers(case: str) -> None:
    got, stored = numbers(case), STORED["cases"][case]
    assert set(got) == set(stored), CURE
    moved = [
        f"{name}: {stored[name]:.12g} -> {value:.12g}"
        for name, value in got.items()
        if not math.isclose(value, stored[name], rel_tol=RELATIVE)
    ]
    assert not moved, (
        f"{case} gives other numbers than physics version {STORED['physics_version']} did: {'; '.join(moved)}. "
        f"If that is meant, raise PHYSICS_VERSION in solver/__init__.py and {CURE}; if not, find what moved them"
    )
