"""For ``studies.runs.execution`` and ``studies.reports.publish`` in a child: those of crash tests, one definition new.

Importing it changes the definition (``tests.service.support.changed_measurement``), so no test imports it. Nothing is
solved any more: a run that is asked for all the same fails, and says so.
"""

from typing import Any

from studies.runs.run import Run
from tests.service.support.chained import publish
from tests.service.support.changed_measurement import raise_the_version

__all__ = ["Run", "execute", "publish"]

raise_the_version()


def execute(run: Run, *_: Any, **__: Any) -> None:
    """Nothing may be solved."""
    raise AssertionError(f"{run.id} was solved")
