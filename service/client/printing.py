"""What the commands of a client print: sweeps, events, the queue."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

from service.cli.console import SHORT_ID, print_table, say
from studies.quantities.display import duration

if TYPE_CHECKING:
    from service.client.client import QueueDocument, SweepEvent
    from service.records.jobs import SweepStatus


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


def print_queue(queue: "QueueDocument") -> None:
    paused = f"paused since {queue['paused']}" if queue["paused"] else "open"
    counts = ", ".join(f"{count} {state}" for state, count in queue["counts"].items() if count)
    say(f"{paused}: {counts or 'empty'}")
    if queue["oldest_queued"]:
        say(f"  oldest run queued since {queue['oldest_queued']}")
    if queue["blocked_reason"]:
        say(f"  no run starts: {queue['blocked_reason']}")
    if queue["deletion_paused"]:
        say(f"  nothing is deleted by age: {queue['deletion_paused']}")
    say(f"  leader: {queue['leader'] or 'none'}")
