"""What the command line prints: findings, states, what happens, and a sweep on its way."""

import math
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import cache
from typing import IO, TYPE_CHECKING, Any, Protocol

from studies.values.errors import InvalidInput
from studies.values.formats import duration

if TYPE_CHECKING:
    from service.cli.backup import Backup
    from service.cli.doctor import Check
    from service.cli.remeasuring import Plan, Renewal
    from service.client.client import Happening
    from service.records.jobs import KeyRow
    from studies.sweeps.cost import Cost, PresetCost

NAMED = 20  # of a list of runs
DONE = ("succeeded", "failed")  # states of a point that was computed


class SweepProgress(Protocol):
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


def print_findings(error: InvalidInput) -> None:
    """Every finding with its value, limit and cure."""
    print("whipple: the input is refused", file=sys.stderr)
    for finding in error.findings:
        print(f"  {finding.field}", file=sys.stderr)
        for word in ("value", "limit", "cure"):
            print(f"    {word:<6} {getattr(finding, word)}", file=sys.stderr)
    if error.more:
        print(f"  and {error.more} more", file=sys.stderr)


def print_sweep(sweep: SweepProgress) -> None:
    """One sweep on a few lines."""
    print(
        f"{sweep.id}  {sweep.name}: {sweep.state}, {sweep.progress:.0%} ({in_words(sweep.counts)})"
    )
    if sweep.reason:
        print(f"  {sweep.reason}")
    if sweep.eta_seconds:
        print(f"  {duration(sweep.eta_seconds)} left")


def print_sweep_line(sweep: SweepProgress) -> None:
    """One of many sweeps."""
    print(
        f"{sweep.id}  {sweep.state:<10}  {sweep.progress:>4.0%}  {sweep.planned:>6} runs  {sweep.name}"
    )


def print_point(point: Mapping[str, Any], units: Mapping[str, str | None]) -> None:
    """A run in its place: where, how it stands, and why; ``units`` are those of the axes."""
    run = point["run"]
    place = _values(point["coordinates"], units)
    attempts = f"  attempt {run['attempt']}" if run["attempt"] > 1 else ""
    print(f"{run['id']}  {point['state']:<10}  {place}{attempts}")
    if run["cause"]:
        print(f"  {run['cause']}: {run['reason']}")


def print_happening(happening: "Happening") -> None:
    """A line of what happens to a sweep; the end is told by whoever waits for it."""
    content = happening.content
    if happening.name == "progress":
        left = f", {duration(content['eta_seconds'])} left" if content["eta_seconds"] else ""
        seen = _values(_rounded(content["measured"]), _units_of_measurements())
        share = "" if content["fraction"] is None else f"{content['fraction']:.0%}"
        print(f"{'':8}  {content['run_id']}  {share}{left}  {seen}".rstrip(), flush=True)
    elif happening.name == "message":
        about = content["sweep_id"] or content["run_id"] or ""
        said = " ".join(f"{k}={_brief(v)}" for k, v in content["body"].items() if v is not None)
        print(f"{content['time'][11:19]}  {about}  {content['kind']}  {said}".rstrip(), flush=True)


def _brief(value: Any) -> str:
    return str(len(value)) if isinstance(value, list | dict) else str(value)


def _values(values: Mapping[str, Any], units: Mapping[str, str | None]) -> str:
    """Named values, each as a sweep takes it: "speed=3 km/s"."""
    from studies.observations import written

    return ", ".join(f"{name}={written(value, units.get(name))}" for name, value in values.items())


def _rounded(measured: Mapping[str, float | None]) -> dict[str, float]:
    """What has been measured until now, to four digits."""
    return {name: float(f"{value:.4g}") for name, value in measured.items() if value is not None}


@cache
def _units_of_measurements() -> Mapping[str, str]:
    from studies import measurements

    return {name: measurements.load(name).unit for name in measurements.names()}


def print_queue(queue: Mapping[str, Any]) -> None:
    """The queue as a whole."""
    paused = f"paused since {queue['paused']}" if queue["paused"] else "open"
    print(f"{paused}: {in_words(queue['counts']) or 'empty'}")
    if queue["oldest_queued"]:
        print(f"  the oldest has waited since {queue['oldest_queued']}")
    if queue["blocked_reason"]:
        print(f"  nothing is begun: {queue['blocked_reason']}")
    print(f"  worked through by {queue['leader'] or 'nobody'}")


def print_key(key: "KeyRow", *, file: IO[str] | None = None) -> None:
    """A key without its secret."""
    until = f"until {key.expires:%Y-%m-%d %H:%M}" if key.expires else "for ever"
    used = f"used {key.used:%Y-%m-%d %H:%M}" if key.used else "never used"
    state = f"revoked {key.revoked:%Y-%m-%d %H:%M}" if key.revoked else until
    scopes = " ".join(sorted(key.scopes))
    print(f"{key.id}  {key.prefix}...  {key.name}: {scopes}, {state}, {used}", file=file)


def print_check(check: "Check") -> None:
    """What the doctor found, and the cure where one is needed."""
    print(f"{check.verdict.upper():<8} {check.name}: {check.detail}", flush=True)
    if check.cure:
        print(f"{'':8} -> {check.cure}")


def print_plan(plan: "Plan") -> None:
    """Which results are outdated, and whether their measurements can be read again."""
    read, stay = len(plan.read), len(plan.not_kept)
    print(f"to read again: {read} results of {len(plan.sweeps)} sweeps; not kept: {stay}")
    _print_some(f"{id} stays as it is: its final state was not kept" for id in plan.not_kept)


def print_renewed(done: "Sequence[Renewal]", names: Mapping[str, str]) -> None:
    """What became of outdated results, and the sweeps that are marked; ``names`` of sweeps by id."""
    unreadable = [one for one in done if one.reason]
    print(f"changed: {len(done) - len(unreadable)} results; unreadable: {len(unreadable)}")
    _print_some(f"{one.run_id} stays as it is: {one.reason}" for one in unreadable)
    marked = {id: None for one in done for id in one.marked}
    print(f"to be published again by the next start of the service: {len(marked)} sweeps")
    for id in marked:
        print(f"  {id}  {names[id]}")


def _print_some(lines: Iterable[str]) -> None:
    """The first lines, and how many more there are."""
    every = list(lines)
    for line in every[:NAMED]:
        print(f"  {line}")
    if len(every) > NAMED:
        print(f"  ... and {len(every) - NAMED} more")


def tracking(renewals: "Iterable[Renewal]", count: int) -> "Iterable[Renewal]":
    """The same renewals, with a bar on a terminal that says how many of them are done."""
    from rich.console import Console
    from rich.progress import track

    screen = Console(stderr=True)
    return track(renewals, "reading", count, console=screen, disable=not screen.is_terminal)


def print_backup(done: "Backup") -> None:
    """What was copied, and what could not be."""
    print(
        f"{done.folder}: {done.copied} files copied ({done.size / 1e6:.1f} MB), {done.known} were there"
    )
    if done.removed:
        print(f"  {done.removed} files were removed by the service meanwhile, and are not in it")
    for path in done.lost[:NAMED]:
        print(f"  lost or damaged: {path}", file=sys.stderr)
    if done.lost:
        print(f"  {len(done.lost)} files are missing; see `whipple doctor`", file=sys.stderr)


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
def watching(name: str) -> Iterator[Callable[[SweepProgress], None]]:
    """Something to tell about a sweep now and then: a bar on a terminal, else lines."""
    if not sys.stderr.isatty():
        yield _Lines(name)
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

        def tell(sweep: SweepProgress) -> None:
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
    """A line each time that more runs have finished, or another tenth of the work is done."""

    def __init__(self, name: str):
        self._name = name
        self._told = (-1, -1)

    def __call__(self, sweep: SweepProgress) -> None:
        done = _finished(sweep)
        now = (done, math.floor(10 * sweep.progress))
        if now == self._told:
            return
        self._told = now
        left = f", {duration(sweep.eta_seconds)} left" if sweep.eta_seconds else ""
        line = f"{self._name}: {done}/{sweep.planned} runs, {sweep.progress:.0%}{left}"
        print(line, file=sys.stderr, flush=True)


def _finished(sweep: SweepProgress) -> int:
    return sum(sweep.counts.get(state, 0) for state in DONE)
