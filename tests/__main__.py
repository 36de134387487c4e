"""Everything that must hold before a change is taken: ``make test``, or ``python -m tests``.

Two groups of stages run side by side: the tests, and the other checks. Each stage runs even when one
before it failed, and prints its time. The budget is the time on two cores above which a stage deserves
attention; a stage that exceeds it does not fail, because machines differ.
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


# Whole files side by side, so that a fixture of a file is made once; four of them on two cores, for tests of processes
# wait half of their time.
SIDE_BY_SIDE = ["--numprocesses=4", "--dist=loadfile", "--no-loadscope-reorder", "--durations=10"]

TESTS = (Stage("tests", 400, ["python", "-m", "pytest", "-q", *SIDE_BY_SIDE]),)
CHECKS = (
    Stage("rules", 10, ["ruff", "check", "--quiet"]),
    Stage("format", 10, ["ruff", "format", "--check", "--quiet"]),
    Stage("types", 180, ["mypy"]),
    Stage("imports", 30, ["lint-imports", "--no-logo", "--cache-dir", ".cache/import-linter"]),
    Stage("quick claims", 180, ["python", "-m", "tests.claims", "--quick"]),
)


def main() -> int:
    """Run every stage, and return 1 when any of them failed."""
    with ThreadPoolExecutor() as pool:
        outcomes = [each for group in pool.map(run, (CHECKS, TESTS)) for each in group]
    print("\n" + "\n".join(str(outcome) for outcome in outcomes))
    passed = sum(outcome.passed for outcome in outcomes)
    print(f"\nstages: {passed} passed, {len(outcomes) - passed} failed")
    return int(passed < len(outcomes))


def run(group: Sequence[Stage]) -> list[Outcome]:
    """Run the stages of a group one after the other."""
    return [run_stage(stage) for stage in group]


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
