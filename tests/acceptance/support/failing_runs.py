"""Runs of ``chained`` of which three fail by their speed: one allocates without end, one never ends, one crashes."""

from pathlib import Path
from typing import Any

from studies.values.results import RunResult
from tests.acceptance.support import chained
from tests.acceptance.support.chained import publish
from tests.service.support import targets
from tests.service.support.targets import Run

__all__ = ["Run", "execute", "publish"]

BEHAVIOURS = {3000.0: "greedy", 3100.0: "deaf", 3200.0: "abort"}  # of ``targets``, by speed


def execute(run: Run, directory: Path, *arguments: Any, **options: Any) -> RunResult:
    """Fail, or compute the result."""
    behaviour = BEHAVIOURS.get(round(run.parameters["speed"], 3))
    if behaviour is not None:
        targets.behave(behaviour, run, directory)
    return chained.execute(run, directory, *arguments, **options)
