"""The real solver and the real publication, but with a checkpoint every tenth of a second.

Stands in for ``studies.runs.execution`` and ``studies.reports.publish``; each attempt leaves its process id in ``pid``.
"""

import os
from functools import partial
from pathlib import Path
from typing import Any

from solver.checkpoints import Checkpointing
from studies.runs import execution
from studies.runs.results import RunResult
from studies.runs.run import Run
from tests.service.support.chained import publish

__all__ = ["Run", "execute", "publish"]

BETWEEN = 0.1  # s; a checkpoint lies behind nearly every kill, so that runs are really resumed


def execute(run: Run, directory: Path, *arguments: Any, **options: Any) -> RunResult:
    (directory / "pid").write_text(str(os.getpid()))
    execution.Checkpointing = partial(Checkpointing, seconds_between=BETWEEN)  # type: ignore[misc,assignment]
    return execution.execute(run, directory, *arguments, **options)
