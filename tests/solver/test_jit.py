"""One text, compiled or not: the same numbers; and a cache that never returns old physics."""

import math
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solver import jit
from solver.eos import pressure_terms, sound_speed_squared, temperature
from solver.eos.tillotson import tillotson
from solver.jit import kernel
from solver.simulation import start
from solver.state import Particles
from solver.strength import melting, stiffness, yield_stress
from solver.strength.elastic import Elastic
from solver.strength.johnson_cook import JohnsonCook
from solver.strength.linear_hardening import LinearHardening
from solver.strength.perfectly_plastic import PerfectlyPlastic
from solver.strength.steinberg_guinan import SteinbergGuinan
from solver.tension import pressure_floor
from solver.tension.recoverable import RecoverableTension
from solver.tension.unlimited import UnlimitedTension
from tests.solver.bodies import DENSITY, real_copper, two_blocks

ROOT = Path(__file__).parents[2]

# Compiled code fuses multiply and add, and has a pow and an exp of its own: a few units in the last place.
LAST_PLACES = 1e-13
# And what a few steps make of them.
AFTER_STEPS = 1e-12
STEPS = 5


@kernel
def compiled_yield_stress(strength, plastic_strain, rate, homologous):
    """The generic function as kernels call it."""
    return yield_stress(strength, plastic_strain, rate, homologous)


@kernel
def compiled_stiffness(strength, density_ratio, pressure, kelvin):
    """Generic functions that have a text for all records and one of their own for some."""
    return stiffness(strength, density_ratio, pressure, kelvin), melting(strength, density_ratio)


@kernel
def compiled_floor(tension, homologous):
    """The generic function as kernels call it."""
    return pressure_floor(tension, homologous)


@kernel
def compiled_state(eos, density, energy):
    """Pressure, square of the sound speed and temperature as kernels get them."""
    a, b = pressure_terms(eos, density, energy)
    pressure = a + b * energy
    sound = sound_speed_squared(eos, density, energy, pressure)
    return pressure, sound, temperature(eos, density, energy)


@kernel
def compiled_is_nan(values):
    """How many NaN a kernel sees, and what comparisons make of them."""
    count = 0
    smaller = 0
    for value in values:
        if math.isnan(value):
            count += 1
        if not abs(value) < 1.0:
            smaller += 1
    return count, smaller


@kernel
def compiled_sum(values):
    """A plain sum from first to last."""
    total = 0.0
    for value in values:
        total += value
    return total


STRENGTHS: tuple[Any, ...] = (
    Elastic(),
    PerfectlyPlastic(240e6),
    LinearHardening(157e6, 425e6),
    JohnsonCook(90e6, 292e6, 0.31, 0.025, 1.09, 1.0),
    SteinbergGuinan(120e6, 640e6, 36.0, 0.45, 28.3e-12, 3.77e-4, 1.5, 2.02),
)


TILLOTSON = tillotson(
    density=DENSITY,
    a=0.5,
    b=1.5,
    A=139e9,
    B=110e9,
    e0=32.5e6,
    e_iv=1.38e6,
    e_cv=6.9e6,
    alpha=5.0,
    beta=5.0,
    heat_capacity=383.0,
    temperature=298.0,
)


def name_of(record: object) -> str:
    return type(record).__name__


@pytest.mark.parametrize("strength", STRENGTHS, ids=name_of)
def test_generic__chooses_the_same_text_compiled_and_plain(strength: Any) -> None:
    for arguments in ((0.2, 1.0, 0.0), (0.0, 1e6, 0.3), (1.5, 0.0, 1.0)):
        compiled = compiled_yield_stress(strength, *arguments)
        assert math.isclose(compiled, yield_stress(strength, *arguments), rel_tol=LAST_PLACES)


def test_generic__gives_each_type_its_own_text() -> None:
    plain = [yield_stress(strength, 0.2, 1.0, 0.0) for strength in STRENGTHS]
    compiled = [compiled_yield_stress(strength, 0.2, 1.0, 0.0) for strength in STRENGTHS]
    assert len(set(plain)) == len(STRENGTHS)
    assert np.allclose(compiled, plain, rtol=LAST_PLACES, atol=0.0)


@pytest.mark.parametrize("strength", STRENGTHS, ids=name_of)
def test_generic__with_a_text_for_all_is_the_same_compiled_and_plain(strength: Any) -> None:
    for arguments in ((1.4, 90e9, 900.0), (0.7, -1e9, 1300.0)):
        plain = compiled_stiffness.py_func(strength, *arguments)
        assert np.allclose(
            compiled_stiffness(strength, *arguments), plain, rtol=LAST_PLACES, atol=0.0
        )
    own = isinstance(strength, SteinbergGuinan)
    assert (stiffness(strength, 1.4, 90e9, 900.0) != 1.0) == own


@pytest.mark.parametrize("tension", [UnlimitedTension(), RecoverableTension(1.9e9)], ids=name_of)
def test_generic__floors_alike_compiled_and_plain(tension: Any) -> None:
    assert compiled_floor(tension, 0.4) == pytest.approx(pressure_floor(tension, 0.4))


@pytest.mark.parametrize("share", [0.4, 0.9, 1.0, 1.4, 2.9])
@pytest.mark.parametrize("eos", [real_copper().eos, TILLOTSON], ids=name_of)
def test_generic__of_generics_answers_alike_compiled_and_plain(eos: Any, share: float) -> None:
    """The pressure of a form asks the form's own reference curve, a generic function again."""
    density, energy = share * DENSITY, 2e6
    plain = compiled_state.py_func(eos, density, energy)
    assert np.allclose(compiled_state(eos, density, energy), plain, rtol=LAST_PLACES, atol=0.0)


def test_generic__has_no_text_for_a_record_of_another_kind() -> None:
    with pytest.raises(KeyError):
        yield_stress(real_copper(), 0.0, 1.0, 0.0)


def test_device__stays_a_plain_function_outside() -> None:
    assert yield_stress.__code__ is not None
    assert isinstance(yield_stress(STRENGTHS[1], 0.0, 1.0, 0.0), float)


def test_kernel__sees_a_nan_and_fails_its_comparisons() -> None:
    assert compiled_is_nan(np.array([0.5, np.nan, np.nan, 2.0])) == (2, 3)


def test_kernel__keeps_the_order_of_a_sum() -> None:
    """1 and then a thousand parts that each vanish beside it; any other order would find them."""
    values = np.array([1.0] + [1e-16] * 1000)
    assert compiled_sum(values) == 1.0


def test_kernel__divides_by_zero_as_ieee_does() -> None:
    eos = real_copper().eos
    assert not math.isfinite(compiled_state(eos, 0.0, 1.0)[1])


# The cache


@pytest.fixture
def copied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the solver's text, which the fingerprint is made to read."""
    copy = tmp_path / "solver"
    shutil.copytree(ROOT / "solver", copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(jit, "__file__", str(copy / "jit.py"))
    return copy


def test_cache__is_named_after_the_text_and_not_after_its_place(
    copied: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    there = jit._cache_directory()
    monkeypatch.setattr(jit, "__file__", str(ROOT / "solver" / "jit.py"))
    assert jit._cache_directory() == there


@pytest.mark.parametrize("file", ["tensor.py", "eos/mie_grueneisen.py", "__init__.py"])
def test_cache__moves_when_any_file_of_the_solver_changes(copied: Path, file: str) -> None:
    before = jit._cache_directory()
    with open(copied / file, "a", encoding="utf-8") as text:
        text.write("\n")
    assert jit._cache_directory() != before


def test_cache__moves_when_a_file_is_added_or_renamed(copied: Path) -> None:
    names = {jit._cache_directory()}
    (copied / "eos" / "tillotson.py").write_text("", encoding="utf-8")
    names.add(jit._cache_directory())
    (copied / "eos" / "tillotson.py").rename(copied / "eos" / "sesame.py")
    names.add(jit._cache_directory())
    assert len(names) == 3


def test_cache__moves_with_the_version_of_the_compiler_and_the_processor(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    before = jit._cache_directory()
    monkeypatch.setattr(jit, "software", lambda: {"numba": "0.0", "cpu": "abacus"})
    assert jit._cache_directory() != before


def test_cache__lies_where_the_environment_says(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("WHIPPLE_KERNEL_CACHE", str(tmp_path))
    assert jit._cache_directory().parent == tmp_path


# Without the compiler

PLAIN_RUN = """
import sys
import numpy as np
from tests.solver.test_jit import a_few_steps
np.savez(sys.argv[1], **a_few_steps()._asdict())
"""


def a_few_steps() -> Particles:
    """Particles of a small impact after a few steps."""
    simulation = start(two_blocks("axisymmetric"), threads=1)
    for _ in range(STEPS):
        simulation.advance()
    return simulation.particles


def test_step__gives_the_same_numbers_without_the_compiler(tmp_path: Path) -> None:
    file = tmp_path / "plain.npz"
    subprocess.run(
        [sys.executable, "-c", PLAIN_RUN, str(file)],
        cwd=ROOT,
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": str(ROOT)},
        check=True,
        timeout=120,
    )
    compiled, plain = a_few_steps(), np.load(file)
    for name in Particles._fields:
        expected = plain[name]
        scale = np.abs(expected).max()
        got = getattr(compiled, name)
        assert np.allclose(got, expected, rtol=0.0, atol=AFTER_STEPS * scale), name
