"""Everything that must hold before a change is taken: ``make test``, or ``python -m tests``.

Each stage runs even when one before it failed, and says how long it took. The budget is what the
stage may take on two cores before it deserves attention; going over it is said and is no failure,
because machines differ.
"""

import os
import subprocess
import sys
import time
from collections.abc import Sequence
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


# Whole files side by side, so that what a file makes once is made once.
SIDE_BY_SIDE = ["--numprocesses=2", "--dist=loadfile", "--no-loadscope-reorder", "--durations=10"]

STAGES = (
    Stage("rules", 10, ["ruff", "check", "--quiet"]),
    Stage("format", 10, ["ruff", "format", "--check", "--quiet"]),
    Stage("types", 120, ["mypy"]),
    Stage("imports", 30, ["lint-imports", "--no-logo", "--cache-dir", ".cache/import-linter"]),
    Stage("tests", 900, ["python", "-m", "pytest", "-q", "-m", "not claim", *SIDE_BY_SIDE]),
    Stage("quick claims", 120, ["python", "-m", "tests.claims", "--quick", "--side-by-side"]),
)


def main() -> int:
    """Run every stage, and return 1 when any of them failed."""
    outcomes = [run(stage) for stage in STAGES]
    print("\n" + "\n".join(str(outcome) for outcome in outcomes))
    passed = sum(outcome.passed for outcome in outcomes)
    print(f"\nstages: {passed} passed, {len(outcomes) - passed} failed")
    return int(passed < len(outcomes))


def run(stage: Stage) -> Outcome:
    """Run one stage, its output shown as it comes."""
    program, *arguments = stage.command
    print(f"\n--- {stage.name}: {' '.join(stage.command)}", flush=True)
    # Hundreds of processes are started: each would compile our modules again if none may keep what it compiled.
    environment = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    begin = time.perf_counter()
    done = subprocess.run([BIN / program, *arguments], cwd=ROOT, env=environment, check=False)
    return Outcome(stage, done.returncode == 0, time.perf_counter() - begin)


if __name__ == "__main__":
    sys.exit(main())
