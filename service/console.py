"""What the command line prints: findings, states, and a sweep on its way."""

import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Protocol

from studies.errors import InvalidInput

if TYPE_CHECKING:
    from studies.cost import Cost, PresetCost

DONE = ("succeeded", "failed", "cancelled")  # states of a point that has ended


class Progress(Protocol):
    """How far a sweep is: a row of the store, or the answer of a service."""

    @property
    def id(self) -> str: ...
    @property
    def name(self) -> str: ...
    @property
    def state(self) -> str: ...
    @property
    def reason(self) -> str | None: ...
    @property
    def planned(self) -> int: ...
    @property
    def counts(self) -> Mapping[str, int]: ...
    @property
    def progress(self) -> float: ...
    @property
    def eta_seconds(self) -> float | None: ...


def duration(seconds: float | None) -> str:
    """A time span for people.

    >>> duration(42.0), duration(90.0), duration(3720.0), duration(None)
    ('42 s', '1 min 30 s', '1 h 02 min', '')
    """
    if seconds is None:
        return ""
    minutes, rest = divmod(round(seconds), 60)
    if minutes == 0:
        return f"{rest} s"
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    return f"{minutes // 60} h {minutes % 60:02d} min"


def print_findings(error: InvalidInput) -> None:
    """Every finding with its value, limit and cure."""
    print("whipple: the input is refused", file=sys.stderr)
    for finding in error.findings:
        print(f"  {finding.field}", file=sys.stderr)
        for word in ("value", "limit", "cure"):
            print(f"    {word:<6} {getattr(finding, word)}", file=sys.stderr)


def print_sweep(sweep: Progress) -> None:
    """One sweep on a few lines."""
    print(
        f"{sweep.id}  {sweep.name}: {sweep.state}, {sweep.progress:.0%} ({in_words(sweep.counts)})"
    )
    if sweep.reason:
        print(f"  {sweep.reason}")
    if sweep.eta_seconds:
        print(f"  {duration(sweep.eta_seconds)} left")


def print_cost(name: str, cost: "Cost", presets: "Iterable[PresetCost]") -> None:
    """What a sweep would cost, and the same at each accuracy."""
    print(f"{name}: {_in_short(cost)}")
    for preset in presets:
        words = _in_short(preset.cost) if preset.cost else f"not offered: {preset.reason}"
        print(f"  accuracy: {preset.name:<9} {words}\n{'':22}{preset.meaning}")


def _in_short(cost: "Cost") -> str:
    time, size = duration(cost.core_seconds), cost.bytes / 1e6
    return f"{cost.runs} runs, about {time} of one core, {size:.0f} MB"


def in_words(counts: Mapping[str, int]) -> str:
    """Points by state, without the empty ones.

    >>> in_words({"queued": 0, "succeeded": 17, "failed": 1})
    '17 succeeded, 1 failed'
    """
    return ", ".join(f"{count} {state}" for state, count in counts.items() if count)


@contextmanager
def watching(name: str) -> Iterator[Callable[[Progress], None]]:
    """Something to tell about a sweep now and then: a bar on a terminal, else a line a finished run."""
    if not sys.stderr.isatty():
        yield _Lines(name)
        return
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bar

    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %  {task.fields[done]}/{task.fields[planned]} runs"),
        TextColumn("{task.fields[left]}"),
    )
    with Bar(*columns, console=Console(stderr=True)) as bar:
        task = bar.add_task(name, total=1.0, done=0, planned=0, left="")

        def tell(sweep: Progress) -> None:
            left = duration(sweep.eta_seconds)
            bar.update(
                task,
                completed=sweep.progress,
                done=_finished(sweep),
                planned=sweep.planned,
                left=f"{left} left" if sweep.eta_seconds else sweep.state,
            )

        yield tell


class _Lines:
    """A line each time that more runs have finished."""

    def __init__(self, name: str):
        self._name = name
        self._told = -1

    def __call__(self, sweep: Progress) -> None:
        done = _finished(sweep)
        if done == self._told:
            return
        self._told = done
        left = f", {duration(sweep.eta_seconds)} left" if sweep.eta_seconds else ""
        print(f"{self._name}: {done}/{sweep.planned} runs{left}", file=sys.stderr, flush=True)


def _finished(sweep: Progress) -> int:
    return sum(sweep.counts.get(state, 0) for state in DONE)
