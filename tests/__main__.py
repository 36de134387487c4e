"""Everything that must hold before a change is taken: ``make test``, or ``python -m tests``.

Stages run side by side, and a stage runs even when another one failed. Each prints its time, and the processor time of
all its processes. The budget is the time on two cores above which a stage deserves attention; a stage that exceeds it
does not fail, because machines differ.
"""

import importlib
import os
import resource
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO

ROOT = Path(__file__).parents[1]
BIN = Path(sys.executable).parent


@dataclass(frozen=True)
class Stage:
    """One check of the test command."""

    name: str
    budget: float  # s
    command: Sequence[str]  # a program of this environment and its arguments


@dataclass(frozen=True)
class Running:
    """A stage that has begun."""

    stage: Stage
    output: IO[bytes]
    begin: float  # s


PYTEST = ("pytest", "-q", "--durations=5", "-W", "ignore::pytest.PytestAssertRewriteWarning")
# Tests of processes, which wait for most of their time, wherever they stand; and so many of the service that the four
# take the same time.
ENGINES = "tests/contracts/test_engine.py"
WAITING = ["tests/crash", ENGINES, *(f"tests/service/{room}" for room in ("workers", "execution", "cli", "queue"))]
WITH_SOLVER = ("tests/service/pages", "tests/service/store")  # beside those of the solver, which end first
TESTS = {
    "crashes": WAITING,
    "service": ["tests/service", *(f"--ignore={path}" for path in (*WAITING, *WITH_SOLVER))],
    "solver": ["tests/cases", "tests/claims", "tests/contracts", "tests/solver", *WITH_SOLVER, f"--ignore={ENGINES}"],
}
# Seconds of imports, which the processes of the tests share: they are forked from this one.
LIBRARIES = (
    *("fastapi.testclient", "hypothesis.stateful", "matplotlib.figure", "netCDF4", "numba", "pandas"),
    *("pint", "psutil", "rich.progress", "scipy.ndimage", "scipy.optimize", "scipy.stats", "sqlalchemy", "xarray"),
)
TYPES = Stage("types", 90, ["mypy", "solver", "studies", "service", "whipple"])  # of tests: make claims types
OF_TESTS = (
    Stage("solver", 250, [*PYTEST, *TESTS["solver"]]),
    Stage("service", 250, [*PYTEST, *TESTS["service"]]),
    Stage("crashes", 250, [*PYTEST, *TESTS["crashes"]]),
    Stage(
        "other tests",
        250,
        [*PYTEST, *(f"--ignore={path}" for paths in TESTS.values() for path in paths if path.startswith("tests"))],
    ),
)
BRIEF = (
    Stage("rules", 5, ["ruff", "check", "--quiet"]),
    Stage("format", 5, ["ruff", "format", "--check", "--quiet"]),
    Stage("imports", 10, ["lint-imports", "--no-logo", "--cache-dir", ".cache/import-linter"]),
)


def main() -> int:
    """Run every stage, and return 1 when any of them failed."""
    os.chdir(ROOT)
    # Hundreds of processes are started: each would compile our modules again if none may keep what it compiled.
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False
    running = dict([begin(TYPES)])  # compiled itself, and the longest on one core
    for library in LIBRARIES:
        importlib.import_module(library)
    running |= map(begin, OF_TESTS)
    lines = []
    for stage in BRIEF:
        pid, started = begin(stage)
        _, status, usage = os.wait4(pid, 0)
        lines.append(end(started, status, usage))
    while running:
        pid, status, usage = os.wait4(-1, 0)
        lines.append(end(running.pop(pid), status, usage))
    print("\n" + "\n".join(lines))
    passed = sum("  passed  " in line for line in lines)
    print(f"\nstages: {passed} passed, {len(lines) - passed} failed")
    return int(passed < len(lines))


def begin(stage: Stage) -> tuple[int, Running]:
    """Begin a stage in a process of its own; its id."""
    output = tempfile.TemporaryFile()  # noqa: SIM115
    if pid := os.fork():
        return pid, Running(stage, output, time.perf_counter())
    for stream in (1, 2):
        os.dup2(output.fileno(), stream)
    program, *arguments = stage.command
    if program == "pytest":
        import pytest  # not above: processes that tests start import this module

        sys.exit(pytest.main(arguments))
    os.execv(BIN / program, [program, *arguments])


def end(running: Running, status: int, usage: resource.struct_rusage) -> str:
    """Print the output of a stage that has ended; the line of its end."""
    stage, seconds = running.stage, time.perf_counter() - running.begin
    word = "FAILED" if status else "passed"
    excess = "  over its budget" if seconds > stage.budget else ""
    computing = usage.ru_utime + usage.ru_stime
    line = f"{stage.name:13}  {word}  {seconds:6.1f} s of {stage.budget:.0f} s, {computing:.0f} s of computing{excess}"
    running.output.seek(0)
    print(
        f"\n--- {stage.name}: {' '.join(stage.command)}\n{running.output.read().decode(errors='replace')}{line}",
        flush=True,
    )
    return line


if __name__ == "__main__":
    sys.exit(main())
