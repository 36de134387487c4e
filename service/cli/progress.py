"""Progress of a sweep while somebody waits: a bar on a terminal, a table in a notebook, else lines or nothing."""

import math
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from importlib import import_module
from typing import TYPE_CHECKING

from solver.registry import points
from studies.quantities.display import duration, escaped

if TYPE_CHECKING:
    from service.records.jobs import SweepStatus

COMPUTED = ("succeeded", "failed")  # states of a computed point

Show = Callable[["SweepStatus"], None]


def watched_progress(name: str) -> AbstractContextManager[Show]:
    """``showing_progress`` where a person looks on, at a terminal or in a notebook; elsewhere nothing is shown."""
    return showing_progress(name) if sys.stderr.isatty() or _in_notebook() else nullcontext(lambda sweep: None)


@contextmanager
def showing_progress(name: str) -> Iterator[Show]:
    """A function that shows the status of a sweep: as a bar on a terminal, a table in a notebook, else as lines."""
    name = escaped(name)
    for point in points("service.cli.progress") if _in_notebook() else ():
        yield _table(point.load())
        return
    if not sys.stderr.isatty():
        yield _lines(name)
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

        def show(sweep: "SweepStatus") -> None:
            bar.update(
                task,
                completed=sweep.progress,
                done=_computed(sweep),
                planned=sweep.planned,
                left=_left(sweep) or sweep.state,
            )

        yield show


def _table(sweep_table: Callable[["SweepStatus"], str]) -> Show:
    """A function that shows a sweep as the HTML of a table with a bar, which takes the place of the last one."""
    ipython = import_module("IPython.display")  # there, in a notebook
    shown = ipython.display(ipython.HTML(""), display_id=True)
    return lambda sweep: shown.update(ipython.HTML(sweep_table(sweep)))


def _lines(name: str) -> Show:
    """A function that writes a line whenever more runs are computed, or another tenth of the work is done."""
    shown = (-1, -1)

    def show(sweep: "SweepStatus") -> None:
        nonlocal shown
        computed = _computed(sweep)
        before, shown = shown, (computed, math.floor(10 * sweep.progress))
        if shown != before:
            left = ", ".join(filter(None, (f"{sweep.progress:.0%}", _left(sweep))))
            print(f"{name}: {computed}/{sweep.planned} runs, {left}", file=sys.stderr, flush=True)

    return show


def _left(sweep: "SweepStatus") -> str:
    """The time left; empty before a run has ended, while kernels are compiled and no speed is known."""
    known = sweep.eta_seconds and _computed(sweep)
    return f"{duration(sweep.eta_seconds)} left" if known else ""


def _computed(sweep: "SweepStatus") -> int:
    return sum(sweep.counts.get(state, 0) for state in COMPUTED)


def _in_notebook() -> bool:
    """Whether IPython runs with a kernel, as it does behind a notebook."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None else None
    return shell is not None and hasattr(shell, "kernel")
