"""Runs of ``chained``, but three of them are trouble: told by their speed.

One allocates without end, one never ends and hears nothing, one crashes the interpreter.
"""

import ctypes
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from studies.results import RunResult
from tests.acceptance.support import chained
from tests.acceptance.support.chained import publish
from tests.service.support.targets import Run

__all__ = ["Run", "execute", "publish"]

MEBIBYTE = 1 << 20
MOST = 8192  # MiB: a machine without limits should survive it
FOREVER = 600  # s; longer than any test waits


def _allocate() -> None:
    hoard = [bytearray(MEBIBYTE) for _ in range(MOST)]
    raise AssertionError(f"{len(hoard)} MiB were allowed")


def _never_end() -> None:
    ctypes.PyDLL(None).sleep(FOREVER)  # holds the interpreter


def _crash() -> None:
    ctypes.string_at(0)


TROUBLES: Mapping[float, Callable[[], None]] = {
    3000.0: _allocate,
    3100.0: _never_end,
    3200.0: _crash,
}


def execute(run: Run, directory: Path, *arguments: Any, **options: Any) -> RunResult:
    """An answer, or trouble."""
    trouble = TROUBLES.get(round(run.parameters["speed"], 3))
    if trouble is not None:
        trouble()
    return chained.execute(run, directory, *arguments, **options)
