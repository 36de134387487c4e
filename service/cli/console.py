"""Output of the command line: errors, sweeps, runs, events, and the progress of a sweep."""

import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from typing import IO, TYPE_CHECKING, Any

from studies.quantities.display import display_of, duration, escaped, with_unit
from studies.quantities.findings import MOST_FINDINGS, InvalidInput

if TYPE_CHECKING:
    from service.cli.backup import Backup
    from service.cli.doctor import Check
    from service.cli.remeasuring import Remeasured, RemeasurePlan
    from service.client.client import SweepEvent
    from service.records.jobs import AuditEntry, ExpiredSweep, KeyRow, SweepStatus
    from studies.sweeps.cost import Cost, PresetCost
    from studies.sweeps.sweep import Sweep

SHORT_ID = 12  # digits of an id in a table; commands take the beginning of an id
MOST_LINES = 20  # printed lines of a list of runs


def say(text: str, *, file: IO[str] | None = None, flush: bool = False) -> None:
    """Print a text that may hold what a user or a service wrote."""
    print(escaped(text), file=file, flush=flush)


def print_findings(error: InvalidInput) -> None:
    """Print every error with its value, limit and cure."""
    say("whipple: invalid input", file=sys.stderr)
    for finding in error.findings:
        say(f"  {finding.field}", file=sys.stderr)
        for name in ("value", "limit", "cure"):
            say(f"    {name:<6} {getattr(finding, name)}", file=sys.stderr)
    if error.more:
        say(f"  and {error.more} more", file=sys.stderr)
    elif len(error.findings) == MOST_FINDINGS:
        say("  and the rest of the input was not read", file=sys.stderr)


def print_warnings(sweep: "Sweep") -> None:
    """Print the doubts about the points of a sweep to the error stream."""
    from studies.sweeps.warnings import warnings_of

    for warning in warnings_of(sweep):
        say(f"whipple: warning: {warning}", file=sys.stderr)


# --- tables and JSON ------------------------------------------------------------------------------


def print_json(value: object) -> None:
    """Print a value as JSON; times in ISO 8601, sets as sorted lists."""
    say(json.dumps(value, indent=2, default=_plain, ensure_ascii=False))


def _plain(value: frozenset[str] | datetime) -> list[str] | str:
    return sorted(value) if isinstance(value, frozenset) else value.isoformat()


def print_table(columns: Sequence[str], rows: Iterable[Sequence[str]], *, file: IO[str] | None = None) -> None:
    """Print rows below their headings; on a terminal wrapped but for the first column, one line each elsewhere."""
    stream = file or sys.stdout
    if not stream.isatty():
        return _print_lines([[*map(escaped, row)] for row in (columns, *rows)], stream)
    from rich.console import Console
    from rich.table import Column, Table

    first, *others = columns
    # A name or an id is typed by whoever read it.
    typed = Column(first, no_wrap=True, overflow="ignore")
    table = Table(typed, *others, box=None, pad_edge=False, padding=(0, 2, 0, 0))
    for row in rows:
        table.add_row(*map(escaped, row))
    Console(file=stream, markup=False, highlight=False, emoji=False).print(table)


def _print_lines(rows: Sequence[Sequence[str]], stream: IO[str]) -> None:
    """Print a line for each row, its cells below one another: fifty times as fast as rich, for thousands of rows."""
    from rich.cells import cell_len

    widths = [[cell_len(cell) for cell in row] for row in rows]
    widest = [max(column) for column in zip(*widths, strict=True)]
    for row, own in zip(rows, widths, strict=True):
        padded = (cell + " " * (wide - width) for cell, width, wide in zip(row, own, widest, strict=True))
        print("  ".join(padded), file=stream)


# --- sweeps and runs ------------------------------------------------------------------------------


def print_sweep(sweep: "SweepStatus") -> None:
    """One sweep on a few lines."""
    pinned = ", pinned" if sweep.pinned else ""
    say(f"{sweep.id}  {sweep.name}: {sweep.state}, {sweep.progress:.0%} ({sweep.tally}){pinned}")
    if sweep.reason:
        say(f"  {sweep.reason}")
    if sweep.renewal:
        say(f"  {sweep.renewal}")
    if sweep.eta_seconds:
        say(f"  {duration(sweep.eta_seconds)} left")


def print_sweeps(sweeps: "Iterable[SweepStatus]") -> None:
    rows = (
        (
            *(sweep.id[:SHORT_ID], sweep.state, f"{sweep.progress:.0%}", str(sweep.planned)),
            *(duration(sweep.eta_seconds or None), sweep.name, sweep.renewal),
        )
        for sweep in sweeps
    )
    print_table(("id", "state", "done", "runs", "time left", "name", ""), rows)


def print_points(points: Iterable[Mapping[str, Any]], axes: Mapping[str, str | None]) -> None:
    """A table of points with the values and units of their axes; failed ones and lost answers with the reason.

    Runs that screen the models have a column of their own in place of the axes.
    """
    points = list(points)
    if any("screening" in point["coordinates"] for point in points):
        axes = {**axes, "screening": None}
    headings = [with_unit(name, unit) for name, unit in axes.items()]
    rows = (
        (
            *(point["run"]["id"][:SHORT_ID], point["state"], str(point["run"]["attempt"])),
            *(_in_unit(point["coordinates"].get(name), unit) for name, unit in axes.items()),
            ": ".join(filter(None, (point["run"]["cause"], point["run"]["reason"]))),
        )
        for point in points
    )
    print_table(("run", "state", "attempt", *headings, "failure"), rows)


def _in_unit(value: float | str | None, unit: str | None) -> str:
    """A value in the display unit of its column, with every digit that it has."""
    if isinstance(value, str) or value is None:
        return value or ""
    return f"{value * display_of(unit).factor:.12g}"


def print_event(event: "SweepEvent") -> None:
    """A line for an event or a progress report; none for the end of the stream."""
    content = event.content
    if event.name == "progress":
        left = f", {duration(content['eta_seconds'])} left" if content["eta_seconds"] else ""
        fraction = "" if content["fraction"] is None else f"{content['fraction']:.0%}"
        say(f"{'':8}  {content['run_id']}  {fraction}{left}  {_measured(content['measured'])}".rstrip(), flush=True)
    elif event.name == "message":
        subject = content["sweep_id"] or content["run_id"] or ""
        details = " ".join(
            f"{name}={len(value) if isinstance(value, list | dict) else value}"
            for name, value in content["body"].items()
            if value is not None
        )
        say(f"{content['time'][11:19]}  {subject}  {content['kind']}  {details}".rstrip(), flush=True)


def _measured(values: Mapping[str, float | None]) -> str:
    """Measured values in the notation of a sweep document: "hole_diameter=14.4 mm"."""
    from studies import measurements
    from studies.observations import written

    units = {name: measurements.load(name).unit for name in measurements.names() if name in values}
    known = {name: float(f"{value:.4g}") for name, value in values.items() if value is not None}
    return ", ".join(f"{name}={written(value, units.get(name))}" for name, value in known.items())


def print_queue(queue: Mapping[str, Any]) -> None:
    paused = f"paused since {queue['paused']}" if queue["paused"] else "open"
    say(f"{paused}: {nonzero(queue['counts']) or 'empty'}")
    if queue["oldest_queued"]:
        say(f"  oldest run queued since {queue['oldest_queued']}")
    if queue["blocked_reason"]:
        say(f"  no run starts: {queue['blocked_reason']}")
    if queue["deletion_paused"]:
        say(f"  nothing is deleted by age: {queue['deletion_paused']}")
    say(f"  leader: {queue['leader'] or 'none'}")


def print_cost(name: str, cost: "Cost", presets: "Iterable[PresetCost]") -> None:
    """The cost of a sweep, as it is and at each accuracy."""
    from studies.sweeps.accuracy import in_percent

    say(f"{name}: {_cost(cost)}")
    for preset in presets:
        text = f"not available: {preset.reason}"
        if preset.cost and preset.cells:
            fewest, most = preset.cells
            cells = f"{fewest:g} cells" if fewest == most else f"{fewest:g} to {most:g} cells"
            text = f"{cells} across the diameter: {_cost(preset.cost)}"
        say(f"  accuracy: {in_percent(preset.error)} ({preset.name})".ljust(28) + text)


def _cost(cost: "Cost") -> str:
    time, size = duration(cost.core_seconds), cost.bytes / 1e6
    memory = f"{cost.memory / 1e6:.0f} MB of memory a run"
    return f"{cost.runs} runs, about {time} of one core, {size:.0f} MB of files, {memory}"


def nonzero(counts: Mapping[str, int]) -> str:
    """Points by state, without zeros.

    >>> nonzero({"queued": 0, "succeeded": 17, "failed": 1})
    '17 succeeded, 1 failed'
    """
    return ", ".join(f"{count} {state}" for state, count in counts.items() if count)


# --- maintenance ----------------------------------------------------------------------------------


def print_keys(keys: "Iterable[KeyRow]", *, file: IO[str] | None = None) -> None:
    """A table of keys without their secrets."""
    rows = (
        (
            *(key.id[:SHORT_ID], f"{key.prefix}...", key.name, " ".join(sorted(key.scopes))),
            *(_moment(key.revoked) and "revoked", _moment(key.expires) or "never"),
            _moment(key.used) or "never",
        )
        for key in keys
    )
    columns = ("id", "secret", "name", "scopes", "state", "expires (UTC)", "used (UTC)")
    print_table(columns, rows, file=file)


def print_expired(sweeps: "Sequence[ExpiredSweep]") -> None:
    """A table of the sweeps that a rule deletes, with their bytes, and the sum of these."""
    rows = (
        (sweep.id[:SHORT_ID], _moment(sweep.finished), f"{sweep.size / 1e6:.1f} MB", sweep.owner, sweep.name)
        for sweep in sweeps
    )
    print_table(("id", "ended (UTC)", "size", "owner", "name"), rows)
    say(f"{len(sweeps)} sweeps, {sum(sweep.size for sweep in sweeps) / 1e6:.1f} MB")


def print_audit(entries: "Iterable[AuditEntry]") -> None:
    """A table of orders, each with the beginning of the ids of its key and its subject."""
    rows = (
        (
            *(f"{entry.time:%Y-%m-%d %H:%M:%S}", entry.owner, (entry.key_id or "")[:SHORT_ID], entry.address),
            *(entry.action, entry.subject[:SHORT_ID], entry.outcome),
        )
        for entry in entries
    )
    print_table(("time (UTC)", "owner", "key", "from", "action", "subject", "outcome"), rows)


def _moment(time: datetime | None) -> str:
    return "" if time is None else f"{time:%Y-%m-%d %H:%M}"


def print_check(check: "Check") -> None:
    say(f"{check.status.upper():<8} {check.name}: {check.detail}", flush=True)
    if check.cure:
        say(f"{'':8} -> {check.cure}")


def print_plan(plan: "RemeasurePlan") -> None:
    """Print the number of outdated results and the results that cannot be measured again."""
    count, lost = len(plan.measurable), len(plan.without_state)
    say(f"to measure again: {count} results of {len(plan.sweeps)} sweeps; without a stored final state: {lost}")
    _print_unchanged([(id, "its final state was not kept") for id in plan.without_state])


def print_remeasured(done: "Sequence[Remeasured]", names: Mapping[str, str]) -> None:
    """The outcome for outdated results, and the sweeps to publish again; ``names`` of sweeps by id."""
    failed = [(result.run_id, result.reason) for result in done if result.reason]
    say(f"changed: {len(done) - len(failed)} results; unreadable: {len(failed)}")
    _print_unchanged(failed)
    marked = {id: None for result in done for id in result.marked}
    say(f"published again at the next start of the service: {len(marked)} sweeps")
    for id in marked:
        say(f"  {id}  {names[id]}")


def _print_unchanged(results: Sequence[tuple[str, str]]) -> None:
    """The first results that stay as they are, with the reasons, and the number of the others."""
    for id, reason in results[:MOST_LINES]:
        say(f"  {id} is unchanged: {reason}")
    if len(results) > MOST_LINES:
        say(f"  ... and {len(results) - MOST_LINES} more")


def print_backup(done: "Backup") -> None:
    say(f"{done.folder}: {done.copied} files copied ({done.size / 1e6:.1f} MB), {done.present} present")
    if done.removed:
        say(f"  {done.removed} files were deleted by the service meanwhile and are left out")
    for path in done.lost[:MOST_LINES]:
        say(f"  lost or damaged: {path}", file=sys.stderr)
    if done.lost:
        say(f"  {len(done.lost)} files are missing; see `whipple doctor`", file=sys.stderr)
