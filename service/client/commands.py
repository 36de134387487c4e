"""Requests to a service over HTTP."""

import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.commands import REQUESTS, Commands
from service.cli.console import SHORT_ID, print_json, print_table, print_warnings, say
from service.cli.options import (
    Accuracy,
    EveryColumn,
    Json,
    KeepOption,
    Laws,
    Overwrite,
    SweepFile,
    document_of,
    exit_status,
    folder_of,
)
from service.cli.progress import showing_progress
from studies.quantities.display import display_of, duration, escaped, with_unit
from studies.quantities.files import ARCHIVE
from studies.quantities.findings import refusal

if TYPE_CHECKING:
    from service.client.client import Client, QueueDocument, SweepEvent, SweepHandle
    from service.records.jobs import SweepStatus

app = typer.Typer()
COMMANDS = Commands("client", REQUESTS, app)

Url = Annotated[str | None, typer.Option(envvar="WHIPPLE_SERVICE", help="Address of the service; default a local one.")]
KeyFile = Annotated[
    Path | None,
    typer.Option(help="File with the API key; default WHIPPLE_API_KEY. Not needed on the service's machine."),
]
SweepArgument = Annotated[str, typer.Argument(metavar="ID", help="Sweep id, or the beginning of it.")]


@app.command()
def submit(
    file: SweepFile,
    priority: Annotated[int, typer.Option(help="-100 to 100; sweeps of smaller numbers are computed first.")] = 0,
    keep: KeepOption = "final",
    idempotency_key: Annotated[
        str | None, typer.Option(help="A text of your choice; a repeated submission with the same text has no effect.")
    ] = None,
    law: Laws = None,
    accuracy: Accuracy = None,
    wait: Annotated[bool, typer.Option("--wait", help="Wait until the sweep has ended.")] = False,
    url: Url = None,
    key_file: KeyFile = None,
) -> None:
    """Submit a sweep to a service, and print its id."""
    from studies.sweeps.reading import ACCEPTED
    from studies.sweeps.sweep import Sweep

    document = document_of(file, law, accuracy)
    with client_of(url, key_file) as client:
        handle = client.submit(document, priority=priority, keep=keep, idempotency_key=idempotency_key)
        accepted = handle.status()
        print_warnings(Sweep.parse(document, ACCEPTED))
        print_sweep(accepted)
        print(f"{accepted.planned} runs: {accepted.reused} reused, {accepted.new} new", file=sys.stderr)
        if wait:
            with showing_progress(accepted.name) as show:
                ended = handle.wait(on_progress=show)
            print_sweep(ended)
            raise typer.Exit(exit_status(ended))
        print(f"watch it with: whipple status {handle.id} --watch --url {client.url}", file=sys.stderr)


@app.command()
def status(
    id: Annotated[
        str | None,
        typer.Argument(metavar="[ID]", help="Id of a sweep, or its beginning; by default all sweeps are shown."),
    ] = None,
    watch: Annotated[bool, typer.Option("--watch", help="Print events until the sweep has ended.")] = False,
    runs: Annotated[
        bool, typer.Option("--runs", help="List its runs, each with its state and, if it failed, the reason.")
    ] = False,
    state: Annotated[
        str | None, typer.Option(help="List only runs in this state: queued, running, succeeded, failed, ...")
    ] = None,
    as_json: Json = False,
    url: Url = None,
    key_file: KeyFile = None,
) -> None:
    """Show the status of a sweep, or of all sweeps. With --watch: its events as they happen; --runs: its runs."""
    if watch and (as_json or runs or state or id is None):
        raise refusal("--watch", "--watch", "with an ID and without --json, --runs and --state", "leave it out")
    if (runs or state) and id is None:
        raise refusal("--runs", "--runs", "with an ID", "name a sweep")
    with client_of(url, key_file) as client:
        if id is None:
            sweeps = list(client.sweeps())
            print_json([vars(sweep) for sweep in sweeps]) if as_json else print_sweeps(sweeps)
            return
        handle = client.find_sweep(id)
        if runs or state:
            _print_runs(handle, state, as_json=as_json)
            return
        now = handle.status()
        print_json(vars(now)) if as_json else print_sweep(now)
        if watch:
            for event in handle.events():
                print_event(event)
            ended = handle.status()
            print_sweep(ended)
            raise typer.Exit(exit_status(ended))


def _print_runs(handle: "SweepHandle", state: str | None, *, as_json: bool) -> None:
    from studies.sweeps.reading import ACCEPTED
    from studies.sweeps.sweep import Sweep

    if as_json:
        print_json(list(handle.runs(state)))
        return
    sweep, points = Sweep.parse(handle.document(), ACCEPTED), list(handle.runs(state))
    axes = {axis.name: axis.unit for axis in (*sweep.axes, *sweep.refinements)}
    # Runs that screen the models have a column of their own in place of the axes.
    if any("screening" in point["coordinates"] for point in points):
        axes["screening"] = None
    rows = (
        (
            *(point["run"]["id"][:SHORT_ID], point["state"], str(point["run"]["attempt"])),
            *(_in_unit(point["coordinates"].get(name), unit) for name, unit in axes.items()),
            ": ".join(filter(None, (point["run"]["cause"], point["run"]["reason"]))),
        )
        for point in points
    )
    headings = [with_unit(name, unit) for name, unit in axes.items()]
    print_table(("run", "state", "attempt", *headings, "failure"), rows)


def _in_unit(value: float | str | None, unit: str | None) -> str:
    """A value in the display unit of its column, with every digit that it has."""
    if isinstance(value, str) or value is None:
        return value or ""
    return f"{value * display_of(unit).factor:.12g}"


@app.command()
def fetch(
    id: Annotated[str, typer.Argument(metavar="ID", help="Id of a sweep, or of a run, or the beginning of it.")],
    out: Annotated[Path | None, typer.Option(help="Folder for the files.")] = None,
    overwrite: Overwrite = False,
    every_column: EveryColumn = False,
    whole: Annotated[
        bool, typer.Option("--zip", help="Download everything as OUT/archive.zip: files of the runs, digests too.")
    ] = False,
    run: Annotated[
        bool, typer.Option("--run", help="Download the files of the run ID: result, final state, film, log.")
    ] = False,
    log: Annotated[
        bool, typer.Option("--log", help="Print what the solver wrote in the last attempt of the run ID, up to now.")
    ] = False,
    url: Url = None,
    key_file: KeyFile = None,
) -> None:
    """Download cube and report of a sweep, all of its files, or those of one run."""
    if whole + run + log > 1:
        raise refusal("fetch", "several files", "one of --zip, --run and --log", "leave the others out")
    with client_of(url, key_file) as client:
        if log:
            print(escaped(client.log(client.find_run(id))), end="")
            return
        if out is None:
            raise refusal("--out", "none", "a folder", "give --out DIR")
        if run:
            folder = client.fetch_run(client.find_run(id), folder_of(out))
            print(", ".join(sorted(str(file) for file in folder.iterdir())))
        elif whole:
            print(client.find_sweep(id).fetch_archive(folder_of(out) / ARCHIVE))
        else:
            done = client.find_sweep(id).fetch(folder_of(out), overwrite=overwrite, every_column=every_column)
            print(f"report: {done / 'report.html'}")


@app.command()
def cancel(id: SweepArgument, url: Url = None, key_file: KeyFile = None) -> None:
    """Stop a sweep. The results so far are published."""
    with client_of(url, key_file) as client:
        print_sweep(client.find_sweep(id).cancel())


@app.command()
def retry(
    id: SweepArgument,
    verdicts: Annotated[
        bool, typer.Option("--verdicts", help="Also repeat runs that the solver rejected; they fail again.")
    ] = False,
    url: Url = None,
    key_file: KeyFile = None,
) -> None:
    """Compute cancelled, failed and lost runs again, then publish again."""
    with client_of(url, key_file) as client:
        print_sweep(client.find_sweep(id).retry(verdicts=verdicts))


@app.command()
def change(
    id: SweepArgument,
    priority: Annotated[
        int | None, typer.Option(help="-100 to 100; smaller numbers are computed first. Running runs continue.")
    ] = None,
    pin: Annotated[
        bool | None, typer.Option("--pin/--unpin", help="Whether it is never deleted, by hand or by a rule.")
    ] = None,
    url: Url = None,
    key_file: KeyFile = None,
) -> None:
    """Change the priority of a sweep, or pin it, so that it is never deleted."""
    if priority is None and pin is None:
        raise refusal("change", "nothing", "--priority, --pin or --unpin", "give one of them")
    with client_of(url, key_file) as client:
        handle = client.find_sweep(id)
        if priority is not None:
            handle.prioritise(priority)
        if pin is not None:
            handle.pin(pinned=pin)
        print_sweep(handle.status())


@app.command()
def delete(id: SweepArgument, url: Url = None, key_file: KeyFile = None) -> None:
    """Delete a sweep that has ended, with cube and report; other sweeps keep its runs."""
    with client_of(url, key_file) as client:
        handle = client.find_sweep(id)
        handle.delete()
    print(f"{handle.id} is deleted")


@app.command()
def queue(
    pause: Annotated[
        bool | None,
        typer.Option("--pause/--resume", help="Start no more runs, or start them again; running runs continue."),
    ] = None,
    as_json: Json = False,
    url: Url = None,
    key_file: KeyFile = None,
) -> None:
    """Show the queue: its jobs by state, its leader, and what blocks it. Pause or resume it."""
    with client_of(url, key_file) as client:
        if pause is None:
            state = client.queue()
        else:
            state = client.pause() if pause else client.resume()
    print_json(state) if as_json else print_queue(state)


def client_of(url: str | None, key_file: Path | None) -> "Client":
    """A client with the key of the options; raises InvalidInput."""
    from service.client.client import Client

    return Client(url, key=None if key_file is None else _key_in(key_file))


def _key_in(file: Path) -> str:
    """The key in a file; raises InvalidInput, which never shows the content."""
    limit = "a file with an API key"
    try:
        words = file.read_text(encoding="utf-8").split()
    except (OSError, UnicodeError) as error:
        cure = f"correct the path: {getattr(error, 'strerror', None) or 'not a text file'}"
        raise refusal("--key-file", str(file), limit, cure) from None
    if len(words) != 1 or not words[0].isascii():
        cure = "write only the secret that `whipple keys create` printed into the file"
        raise refusal("--key-file", str(file), limit, cure)
    return words[0]


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
