"""Runs and tests that claims compute by themselves, and where."""

import functools
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from studies.runs.execution import execute
from studies.runs.run import Run
from tests.claims import Row

ROOT = Path(__file__).parents[2]
COUNTS = re.compile(r"(\d+) (passed|failed|error|errors|skipped)")  # last line of pytest


@functools.cache
def scratch() -> tempfile.TemporaryDirectory[str]:
    """A folder that goes when the process ends."""
    return tempfile.TemporaryDirectory(prefix="whipple-claims-")


def result_of(run: Run, folder: Path) -> dict[str, Any]:
    """The result of a run as a program reads it from its file."""
    directory = folder / "runs" / run.id
    directory.mkdir(parents=True)
    execute(run, directory)
    plain: dict[str, Any] = json.loads((directory / "result.json").read_text(encoding="utf-8"))
    return plain


def rows_of_tests(tests: str, environment: Mapping[str, str] | None = None) -> Iterator[Row]:
    """The tests of a file, or one of them, run now with these variables (more examples than usual)."""
    more = environment or {}
    command = [sys.executable, "-m", "pytest", "-q", tests]
    answer = subprocess.run(command, cwd=ROOT, env={**os.environ, **more}, capture_output=True, text=True, check=False)
    counts = {word: int(number) for number, word in COUNTS.findall(answer.stdout)}
    settings = "".join(f" {name}={value}" for name, value in more.items())
    bad = sum(count for word, count in counts.items() if word != "passed")
    is_fine = answer.returncode == 0 and bad == 0 and counts.get("passed", 0) > 0
    yield Row(f"{tests}{settings}: findings", "none", _findings(answer.stdout, bad), is_fine)
    yield Row("tests that passed", "", counts.get("passed", 0), None)


def _findings(output: str, bad: int) -> str:
    return "none" if not bad else f"{bad}: {output[-1000:]}"
