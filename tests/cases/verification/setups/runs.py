"""Whole runs of scenarios, for the cases whose set-up is one."""

import tempfile
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from solver.errors import WhippleError
from studies.quantities.numerical_defaults import Recipe
from studies.runs.execution import execute
from studies.runs.results import RunResult
from studies.runs.run import resolve


def executed(
    scenario: str, recipe: Recipe, parameters: Mapping[str, Any], materials: Mapping[str, str] | None = None
) -> RunResult:
    """The result of a scenario with the numerics of a recipe; raises WhippleError where the run failed."""
    run = resolve(scenario, {**asdict(recipe), **(materials or {}), **parameters})
    with tempfile.TemporaryDirectory() as folder:
        result = execute(run, Path(folder), threads=1)
    if result.state != "succeeded":
        raise WhippleError(f"{scenario}: {result.reason}")
    return result
