"""Small runs, one of each family, solved once a process."""

import json
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from studies.runs.execution import execute
from studies.runs.run import Run
from tests import samples
from tests.contracts import test_scenarios as contract

PLATE = {"plate_thickness": 2e-3, "plate_radius": 16e-3, "end_time": 4e-6}
# On top of the small parameters of each scenario's contract.
OWN: dict[str, dict[str, Any]] = {"thin_plate": PLATE}
RUNS = samples.joined("SOLVED", OWN)
BROKEN_OFF_AFTER = 23  # steps; between two observations in each of the runs


def asked(scenario: str, **changes: Any) -> Run:
    return contract.asked(scenario, **{**RUNS[scenario], **changes})


def after(steps: int) -> Callable[[], bool]:
    """Says yes once it has been asked that often."""
    counts = iter(range(1, steps))
    return lambda: next(counts, None) is None


@cache
def _folder() -> tempfile.TemporaryDirectory[str]:
    """A folder that goes when the process ends."""
    return tempfile.TemporaryDirectory(prefix="whipple-solved-")


@cache
def solved(scenario: str) -> Path:
    """The folder of the solved run of a scenario: read only."""
    folder = Path(_folder().name) / scenario
    execute(asked(scenario), folder, threads=1)
    return folder


def stored(directory: Path) -> dict[str, Any]:
    """The result in a folder, which holds no number that JSON has not."""

    def refuse(constant: str) -> None:
        raise AssertionError(f"result.json holds {constant}")

    text = (directory / "result.json").read_text(encoding="utf-8")
    return json.loads(text, parse_constant=refuse)
