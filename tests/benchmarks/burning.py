"""Runs that keep a core busy for about a second, and nothing else. Stands in for ``studies.runs.execution``."""

import json
from pathlib import Path
from typing import Any

from studies.quantities.files import write_text
from studies.quantities.measured import Measured
from studies.runs.results import RunResult
from tests.crash.support.chained import publish
from tests.service.support.targets import Run

__all__ = ["Run", "execute", "publish"]

TURNS = 10_000_000  # about a second of a core


def burn(turns: int = TURNS) -> int:
    """The work itself: a linear congruential generator."""
    number = 1
    for _ in range(turns):
        number = (1103515245 * number + 12345) & 0x7FFFFFFF
    return number


def execute(run: Run, directory: Path, *_arguments: Any, **_options: Any) -> RunResult:
    hole = Measured(0.01 + burn() * 1e-15, 1e-4, {}, (), {"time": [0.0], "value": [0.01]}, 1)
    measured = {"hole_diameter": hole}
    result = RunResult(run.id, "succeeded", measurements=measured, numbers={}, stop="settled", provenance={})
    write_text(directory / "result.json", json.dumps(result.as_json()))
    return result
