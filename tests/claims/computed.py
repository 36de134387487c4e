"""Runs that claims compute by themselves, and where."""

import functools
import json
import tempfile
from pathlib import Path
from typing import Any

from studies.run import Run, execute


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
