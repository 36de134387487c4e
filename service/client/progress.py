"""Progress of a sweep while somebody waits: a bar on a terminal, a table in a notebook, else lines or nothing."""

import math
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module

from service.client.html import sweep_table
from service.records.jobs import SweepStatus
from studies.quantities.display import duration, escaped

COMPUTED = ("succeeded", "failed")  # states of a computed point

Show = Callable[[SweepStatus], None]


def is_watched() -> bool:
    """Whether a person looks on: the error stream is a terminal, or this is a notebook."""
    return sys.stderr.isatty() or _in_notebook()


@contextmanager
def showing_progress(name: str) -> Iterator[Show]:
    """A function that shows the status of a sweep: as a bar on a terminal, a table in a notebook, else as lines."""
    name = escaped(name)
    if _in_notebook():
        yield _ProgressTable()
        return
    if not sys.stderr.isatty():
        yield _ProgressLines(name)
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %  {task.fields[done]}/{task.fields[planned]} runs"),
        TextColumn("{task.fields[left]}"),
    )
    with Progress(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(name, total=1.0, done=0, planned=0, left="")

        def show(sweep: SweepStatus) -> None:
            bar.update(
                task,
                completed=sweep.progress,
                done=_computed(sweep),
                planned=sweep.planned,
                left=_left(sweep) or sweep.state,
            )

        yield show


class _ProgressTable:
    """The sweep as a table with a bar, which takes the place of the last one."""

    def __init__(self) -> None:
        self._ipython = import_module("IPython.display")  # there, in a notebook
        self._shown = self._ipython.display(self._ipython.HTML(""), display_id=True)

    def __call__(self, sweep: SweepStatus) -> None:
        self._shown.update(self._ipython.HTML(sweep_table(sweep)))


class _ProgressLines:
    """A line whenever more runs are computed, or another tenth of the work is done."""

    def __init__(self, name: str):
        self._name = name
        self._shown = (-1, -1)

    def __call__(self, sweep: SweepStatus) -> None:
        computed = _computed(sweep)
        now = (computed, math.floor(10 * sweep.progress))
        if now == self._shown:
            return
        self._shown = now
        left = ", ".join(filter(None, (f"{sweep.progress:.0%}", _left(sweep))))
        line = f"{self._name}: {computed}/{sweep.planned} runs, {left}"
        print(line, file=sys.stderr, flush=True)


def _left(sweep: SweepStatus) -> str:
    """The time left; empty before a run has ended, while kernels are compiled and no speed is known."""
    known = sweep.eta_seconds and _computed(sweep)
    return f"{duration(sweep.eta_seconds)} left" if known else ""


def _computed(sweep: SweepStatus) -> int:
    return sum(sweep.counts.get(state, 0) for state in COMPUTED)


def _in_notebook() -> bool:
    """Whether IPython runs with a kernel, as it does behind a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and hasattr(shell, "kernel")
