"""Compiled and plain steps agree, kernels keep the order of sums, and the cache never returns old physics.

NaN, infinity and division by zero are those of IEEE: ``test_vectors``. That every law is the same compiled, by eights
and plain is a contract: ``tests/contracts/test_eight_points.py``.
"""

import errno
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from solver import jit
from solver.jit import kernel
from solver.state import Particles
from tests.claims.rows import Row, equal
from tests.solver.bodies import after, two_blocks

ROOT = Path(__file__).parents[2]

# Compiled code fuses multiply and add, and has a pow and an exp of its own: what a few steps make of the last place.
AFTER_STEPS = 1e-12
STEPS = 2


@kernel
def compiled_sum(values):
    """A plain sum from first to last."""
    total = 0.0
    for value in values:
        total += value
    return total


def test_kernel__keeps_the_order_of_a_sum() -> None:
    """1 and then a thousand parts that each vanish beside it; any other order would find them."""
    assert compiled_sum(np.array([1.0] + [1e-16] * 1000)) == 1.0


# The cache


@pytest.fixture
def copied(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the solver's text, which the fingerprint is made to read."""
    copy = tmp_path / "solver"
    shutil.copytree(ROOT / "solver", copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(jit, "__file__", str(copy / "jit.py"))
    return copy


@kernel
def doubled(value):
    return 2.0 * value


def test_kernel__is_compiled_where_the_cache_cannot_be_written(monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.EROFS, "read-only")

    monkeypatch.setattr(f"{__name__}.doubled._cache.load_overload", lambda *_: None)
    monkeypatch.setattr(f"{__name__}.doubled._cache.save_overload", full)
    assert doubled(2.5) == 5.0


def test_cache__moves_with_the_text_of_the_solver_and_not_with_its_place(
    copied: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    names = [jit._cache_directory("processor")]
    for file in ("matter/tensor.py", "matter/eos/mie_grueneisen.py", "__init__.py"):
        with open(copied / file, "a", encoding="utf-8") as text:
            text.write("\n")
        names.append(jit._cache_directory("processor"))
    (copied / "matter" / "eos" / "added.py").write_text("", encoding="utf-8")
    names.append(jit._cache_directory("processor"))
    (copied / "matter" / "eos" / "added.py").rename(copied / "matter" / "eos" / "renamed.py")
    names.append(jit._cache_directory("processor"))
    assert len(set(names)) == 6
    monkeypatch.setattr(jit, "__file__", str(ROOT / "solver" / "jit.py"))
    assert jit._cache_directory("processor") == names[0]


SECOND_CHECKOUT = """
import numba.core.event
with numba.core.event.install_recorder("numba:compile") as compiled:
    from tests.solver.test_jit import a_few_steps
    import solver
    position = a_few_steps().position.tobytes().hex()
print(solver.__file__, len(compiled.buffer), position)
"""


@pytest.mark.claim("mend-again", "second-checkout")
def test_cache__serves_another_checkout(tmp_path: Path, compared: Callable[[Row], None]) -> None:
    """A second checkout with the first one's cache compiles nothing."""
    for room in ("solver", "tests"):
        shutil.copytree(ROOT / room, tmp_path / room, ignore=shutil.ignore_patterns("__pycache__"))
    position = a_few_steps().position
    done = subprocess.run(
        [sys.executable, "-c", SECOND_CHECKOUT],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        check=True,
        capture_output=True,
        text=True,
        timeout=120,
    )
    place, compilations, there = done.stdout.split()
    compared(equal("text of the solver", expected=str(tmp_path / "solver/__init__.py"), got=place))
    compared(equal("compilations", expected=0, got=int(compilations)))
    compared(equal("bits", expected="the same", got="the same" if there == position.tobytes().hex() else "others"))


# Without the compiler

PLAIN_RUN = """
import sys
import numpy as np
from tests.solver.test_jit import a_few_steps
np.savez(sys.argv[1], **a_few_steps()._asdict())
"""


def a_few_steps() -> Particles:
    return after(two_blocks("axisymmetric"), STEPS).particles


@pytest.mark.claim("speed", "same-bits")
def test_step__gives_the_same_numbers_without_the_compiler(tmp_path: Path) -> None:
    """Plain Python gives the numbers of compiled steps but for round-off."""
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
