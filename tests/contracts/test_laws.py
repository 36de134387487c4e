"""Every law reproduces a published number, broadcasts and states its range."""

import doctest
import importlib
import inspect
import math
from collections.abc import Callable

import numpy as np
import pytest

from solver.registry import entries
from studies import laws, materials
from studies.laws import Law, Shot
from studies.materials.schema import CONFIDENCES

COPPER = materials.load("copper-ofhc")
ALUMINIUM = materials.load("al-2024-t3")


@pytest.fixture(params=list(entries("studies.laws", "LAW")))
def law(request: pytest.FixtureRequest) -> Law:
    return laws.load(request.param)


def shot(speed: float = 6000.0, thickness: float | None = 2e-3) -> Shot:
    return Shot(speed, 8e-3, thickness, COPPER, COPPER)


def module_of(law: Law) -> object:
    return importlib.import_module(f"studies.laws.{law.name}")


def formula_of(law: Law) -> Callable[..., np.ndarray]:
    """The bare formula: the public function whose name ends in ratio."""
    result = inspect.getmembers(module_of(law), inspect.isfunction)
    (formula,) = [
        one
        for name, one in result
        if name.endswith("_ratio")
        and name[0] != "_"
        and one.__module__ == f"studies.laws.{law.name}"
    ]
    return formula


def test_law__states_equation_source_and_confidence(law: Law) -> None:
    assert "=" in law.equation
    assert len(law.source) > 10
    assert law.confidence in CONFIDENCES


def test_law__states_a_range_with_sources_of_which_some_is_checked(law: Law) -> None:
    assert law.range.words
    assert any(limit.machine_checked for limit in law.range.limits)
    assert all(len(limit.source) > 5 and "memory" not in limit.source for limit in law.range.every)


def test_law__has_a_published_scatter_or_none(law: Law) -> None:
    assert law.scatter is None or 0.0 < law.scatter < 1.0
    assert law.describe()["scatter"] == law.scatter


def test_law__has_a_doctest_that_passes(law: Law) -> None:
    formula = formula_of(law)
    assert ">>>" in (formula.__doc__ or "")
    assert doctest.testmod(module_of(law)).failed == 0  # type: ignore[arg-type]


def test_law__broadcasts(law: Law) -> None:
    formula = formula_of(law)
    count = len(inspect.signature(formula).parameters)
    speeds = np.linspace(3000.0, 7000.0, 4)[:, np.newaxis]
    others = [np.full(3, 0.25) for _ in range(count - 1)]
    assert formula(speeds, *others).shape == (4, 3)
    assert formula(6000.0, *[0.25] * (count - 1)).shape == ()


def test_law__grows_with_speed(law: Law) -> None:
    for variant in law.variants(shot()):
        values = [law.evaluate(shot(speed), variant).value for speed in (3e3, 5e3, 7e3)]
        assert values == sorted(values)
        assert all(math.isfinite(value) and 0.0 < value < 0.1 for value in values)


def test_law__scales_with_the_projectile(law: Law) -> None:
    """The laws that ship are ratios: twice the shot is twice the hole."""
    for variant in law.variants(shot()):
        one = law.evaluate(shot(), variant).value
        two = law.evaluate(Shot(6e3, 16e-3, 4e-3, COPPER, COPPER), variant).value
        assert math.isclose(two, 2.0 * one, rel_tol=1e-12)


@pytest.mark.parametrize("speed", [10.0, 500.0, 1000.0, 2000.0, 6000.0, 20000.0])
def test_law__gives_a_reason_wherever_it_is_out_of_range(law: Law, speed: float) -> None:
    for variant in law.variants(shot()):
        answer = law.evaluate(shot(speed), variant)
        assert answer.in_range == (answer.reason == "")
        assert math.isfinite(answer.value) or not answer.in_range


def test_law__band_is_the_smallest_to_the_largest_variant(law: Law) -> None:
    values = [law.evaluate(shot(), variant).value for variant in law.variants(shot())]
    assert law.band(shot()) == (min(values), max(values))
