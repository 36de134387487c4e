"""Whole runs of scenarios, for the cases whose set-up is one."""

import tempfile
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from solver.errors import WhippleError
from studies.materials import load
from studies.runs.execution import execute
from studies.runs.run import resolve
from studies.values.recipes import Recipe
from studies.values.results import RunResult


def executed(
    scenario: str, recipe: Recipe, parameters: Mapping[str, Any], materials: Mapping[str, str] | None = None
) -> RunResult:
    """The result of a scenario with the numerics of a recipe; raises WhippleError where the run failed."""
    named = dict(materials or {})
    values = {**asdict(recipe), **named, **parameters}
    run = resolve(scenario, values, {role: load(name) for role, name in named.items()})
    with tempfile.TemporaryDirectory() as folder:
        result = execute(run, Path(folder), threads=1)
    if result.state != "succeeded":
        raise WhippleError(f"{scenario}: {result.reason}")
    return result


def value(result: RunResult, name: str) -> float:
    """A measured value; NaN where there is none."""
    measured = result.measurements[name].value
    return float("nan") if measured is None else float(measured)
