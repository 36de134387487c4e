"""Every law reproduces a published number, broadcasts and states its range."""

import doctest
import importlib
import inspect
import math
import pkgutil
from collections.abc import Callable

import numpy as np
import pytest

from solver.registry import entries, folders
from studies import laws, materials, measurements
from studies.laws import Law, Shot
from studies.materials.schema import CONFIDENCES
from tests import samples

COPPER = materials.load("copper-ofhc")


@pytest.fixture(params=list(entries("studies.laws", "LAW")))
def law(request: pytest.FixtureRequest) -> Law:
    return laws.load(request.param)


def shot(law: Law, speed: float = 6000.0, scale: float = 1.0) -> Shot:
    """A sphere of 8 mm on 2 mm of copper, all lengths times a scale; at the target that a law of a feature is about."""
    plain = Shot(speed, 8e-3 * scale, 2e-3 * scale, COPPER, COPPER)
    at_target = samples.joined("LAW_SHOTS", {}).get(law.quantity)
    return at_target(law, plain, scale) if at_target else plain


def formula_of(law: Law) -> Callable[..., np.ndarray]:
    """The bare formula: the public function whose name ends in ratio, or that of a critical diameter."""
    modules = ((folder, found) for folder in folders(laws.__name__) for found in pkgutil.iter_modules(folder.__path__))
    for folder, found in modules:
        module = importlib.import_module(f"{folder.__name__}.{found.name}")
        offered = getattr(module, "LAW", ())
        if law in (offered if isinstance(offered, tuple) else (offered,)):
            (formula,) = [
                each
                for name, each in inspect.getmembers(module, inspect.isfunction)
                if name.endswith(("_ratio", "critical_diameter"))
                and name[0] != "_"
                and each.__module__ == module.__name__
            ]
            return formula
    raise AssertionError(law.name)


def test_law__states_equation_source_and_confidence(law: Law) -> None:
    assert "=" in law.equation
    assert law.latex.count("$") % 2 == 0
    assert len(law.source) > 10
    assert law.confidence in CONFIDENCES


def test_law__predicts_what_is_measured_or_what_is_listed_as_unmeasured(law: Law) -> None:
    assert (law.quantity in measurements.names()) != (law.quantity in laws.unmeasured())


def test_law__states_a_range_with_sources_of_which_some_is_checked(law: Law) -> None:
    assert "0.5 <= projectile L/d <= 2 (source not found; checked)" in laws.range_in_words(law.range)
    assert any(limit.machine_checked for limit in law.range.limits)
    assert all(len(limit.source) > 5 and "memory" not in limit.source for limit in law.range.every)


def test_law__has_a_published_scatter_or_none(law: Law) -> None:
    assert law.scatter is None or 0.0 < law.scatter < 1.0
    assert law.describe()["scatter"] == law.scatter


@pytest.mark.claim("laws", "laws-published-numbers")
def test_law__has_a_doctest_that_passes(law: Law) -> None:
    """Every law gives the numbers beside its formula, published ones where there are some, to their printed digits."""
    formula = formula_of(law)
    assert ">>>" in (formula.__doc__ or "")
    failed, attempted = doctest.testmod(inspect.getmodule(formula))
    assert attempted > failed == 0


def test_law__broadcasts(law: Law) -> None:
    formula = formula_of(law)
    count = len(inspect.signature(formula).parameters)
    speeds = np.linspace(3000.0, 7000.0, 4)[:, np.newaxis]
    arguments = samples.joined("FORMULA_ARGUMENTS", {}).get(law.quantity)
    if arguments:
        assert formula(speeds, *arguments(law)).shape == (4, 1)
        return
    others = [np.full(3, 0.25) for _ in range(count - 1)]
    assert formula(speeds, *others).shape == (4, 3)
    assert formula(6000.0, *[0.25] * (count - 1)).shape == ()


def test_law__grows_with_speed__and_critical_diameters_fall_beyond_shatter(law: Law) -> None:
    critical = law.quantity.endswith("critical_diameter")
    speeds = (7e3, 9e3, 12e3) if critical else (3e3, 5e3, 7e3)
    for variant in law.variants(shot(law)):
        values = [law.evaluate(shot(law, speed), variant).value for speed in speeds]
        assert values == sorted(values, reverse=critical)
        assert all(math.isfinite(value) and 0.0 < value < 0.1 for value in values)


def test_law__scales_with_the_shot_as_it_states(law: Law) -> None:
    """Twice the shot is twice the hole, or the power of two that the law states."""
    for variant in law.variants(shot(law)):
        value, doubled = (law.evaluate(shot(law, scale=scale), variant).value for scale in (1.0, 2.0))
        exponent = math.log2(doubled / value)
        if law.size_exponent is not None:
            assert math.isclose(exponent, law.size_exponent, rel_tol=1e-12)
        assert 0.9 < exponent / law.dimension < 1.1


@pytest.mark.parametrize("speed", [10.0, 500.0, 1000.0, 2000.0, 6000.0, 20000.0])
def test_law__gives_a_reason_wherever_it_is_out_of_range(law: Law, speed: float) -> None:
    for variant in law.variants(shot(law)):
        answer = law.evaluate(shot(law, speed), variant)
        assert answer.in_range == (not answer.reasons)
        assert math.isfinite(answer.value) or not answer.in_range


def test_law__band_is_the_smallest_to_the_largest_variant(law: Law) -> None:
    values = [law.evaluate(shot(law), variant).value for variant in law.variants(shot(law))]
    assert law.band(shot(law)) == (min(values), max(values))
