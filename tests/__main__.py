"""Everything that must hold before a change is taken: ``make test``, or ``python -m tests``.

Stages run side by side, and a stage runs even when another one failed. Each prints its time. The budget is the time on
two cores above which a stage deserves attention; a stage that exceeds it does not fail, because machines differ.
"""

import os
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
BIN = Path(sys.executable).parent


@dataclass(frozen=True)
class Stage:
    """One check of the test command."""

    name: str
    budget: float  # s
    command: Sequence[str]  # a program of this environment and its arguments


@dataclass(frozen=True)
class Outcome:
    """How a stage ended."""

    stage: Stage
    passed: bool
    seconds: float

    def __str__(self) -> str:
        word = "passed" if self.passed else "FAILED"
        excess = "  over its budget" if self.seconds > self.stage.budget else ""
        time_taken = f"{self.seconds:6.1f} s of {self.stage.budget:.0f} s"
        return f"{self.stage.name:13}  {word}  {time_taken}{excess}"


# Five on two cores, for tests of processes wait half of their time. Each collection of tests costs seconds of imports,
# so there are few: two that wait, and two that compute.
SIDE_BY_SIDE = 5

PYTEST = ("pytest", "-q", "--durations=5")
# Tests of processes, which wait for most of their time, wherever they stand; and so many of the service that the four
# take the same time.
ENGINES = "tests/contracts/test_engine.py"
WAITING = ["tests/crash", ENGINES, *(f"tests/service/{room}" for room in ("workers", "execution", "cli", "queue"))]
TESTS = {
    "crashes": WAITING,
    "service": ["tests/service", *(f"--ignore={path}" for path in WAITING)],
    "solver": ["tests/cases", "tests/claims", "tests/contracts", "tests/solver", f"--ignore={ENGINES}"],
}
# Python compiles the installed modules when they are first imported: here once, before five processes do it at a time.
MODULES = Stage(
    "modules",
    15,
    [
        "python",
        "-c",
        "import distributed, fastapi.testclient, hypothesis, matplotlib.figure, numba"
        ", pandas, pint, rich, scipy.ndimage, scipy.optimize, scipy.stats, xarray",
    ],
)
# In the order in which they begin, long ones first.
TYPES = Stage("types", 90, ["mypy", "solver", "studies", "service", "whipple"])  # of tests: make claims types
STAGES = (
    Stage("rules", 5, ["ruff", "check", "--quiet"]),
    Stage("format", 5, ["ruff", "format", "--check", "--quiet"]),
    Stage("solver", 250, [*PYTEST, *TESTS["solver"]]),
    Stage("service", 250, [*PYTEST, *TESTS["service"]]),
    Stage("crashes", 250, [*PYTEST, *TESTS["crashes"]]),
    Stage(
        "other tests",
        250,
        [*PYTEST, *(f"--ignore={path}" for paths in TESTS.values() for path in paths if path.startswith("tests"))],
    ),
    Stage("imports", 10, ["lint-imports", "--no-logo", "--cache-dir", ".cache/import-linter"]),
)


def main() -> int:
    """Run every stage, and return 1 when any of them failed."""
    with ThreadPoolExecutor(SIDE_BY_SIDE) as pool:
        types = pool.submit(run_stage, TYPES)  # compiled itself, and the longest on one core
        outcomes = [run_stage(MODULES), *pool.map(run_stage, STAGES), types.result()]
    print("\n" + "\n".join(str(outcome) for outcome in outcomes))
    passed = sum(outcome.passed for outcome in outcomes)
    print(f"\nstages: {passed} passed, {len(outcomes) - passed} failed")
    return int(passed < len(outcomes))


def run_stage(stage: Stage) -> Outcome:
    """Run one stage, and print its output when it has ended."""
    program, *arguments = stage.command
    # Hundreds of processes are started: each would compile our modules again if none may keep what it compiled.
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    begin = time.perf_counter()
    done = subprocess.run(
        [BIN / program, *arguments],
        cwd=ROOT,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    outcome = Outcome(stage, done.returncode == 0, time.perf_counter() - begin)
    print(f"\n--- {stage.name}: {' '.join(stage.command)}\n{done.stdout}{outcome}", flush=True)
    return outcome


if __name__ == "__main__":
    sys.exit(main())
