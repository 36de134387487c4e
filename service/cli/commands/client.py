"""Requests to a service over HTTP."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.commands.options import (
    FAILURE,
    SOME_FAILED,
    SUCCESS,
    Accuracy,
    EveryColumn,
    Json,
    KeepOption,
    KeyFile,
    Laws,
    Out,
    Overwrite,
    RunArgument,
    SweepArgument,
    SweepFile,
    Url,
    client_of,
    document_of,
    folder_of,
)
from service.cli.console import (
    print_event,
    print_json,
    print_points,
    print_queue,
    print_sweep,
    print_sweeps,
    print_warnings,
)
from studies.quantities.display import escaped
from studies.quantities.files import ARCHIVE
from studies.quantities.findings import Finding, InvalidInput

if TYPE_CHECKING:
    from service.client.client import SweepHandle, SweepStatus

app = typer.Typer()


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
    from service.client.progress import showing_progress
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
            raise typer.Exit(_exit_status(ended))
        print(f"watch it with: whipple status {handle.id} --watch --url {client.url}", file=sys.stderr)


@app.command()
def status(
    id: Annotated[
        str | None,
        typer.Argument(metavar="[ID]", help="Id of a sweep, or its beginning; by default all sweeps are shown."),
    ] = None,
    watch: Annotated[bool, typer.Option("--watch", help="Print events until the sweep has ended.")] = False,
    as_json: Json = False,
    url: Url = None,
    key_file: KeyFile = None,
) -> None:
    """Show the status of a sweep, or of all sweeps. With --watch: its events as they happen."""
    if watch and (as_json or id is None):
        raise InvalidInput([Finding("--watch", "--watch", "with an ID and without --json", "leave it out")])
    with client_of(url, key_file) as client:
        if id is None:
            sweeps = list(client.sweeps())
            print_json([vars(sweep) for sweep in sweeps]) if as_json else print_sweeps(sweeps)
            return
        handle = client.find_sweep(id)
        status = handle.status()
        print_json(vars(status)) if as_json else print_sweep(status)
        if watch:
            for event in handle.events():
                print_event(event)
            ended = handle.status()
            print_sweep(ended)
            raise typer.Exit(_exit_status(ended))


@app.command()
def runs(
    id: SweepArgument,
    state: Annotated[
        str | None, typer.Option(help="Show only runs in this state: queued, running, succeeded, failed, ...")
    ] = None,
    as_json: Json = False,
    url: Url = None,
    key_file: KeyFile = None,
) -> None:
    """List the runs of a sweep, each with its state and, if it failed, the reason."""
    from studies.sweeps.reading import ACCEPTED
    from studies.sweeps.sweep import Sweep

    with client_of(url, key_file) as client:
        handle = client.find_sweep(id)
        if as_json:
            print_json(list(handle.runs(state)))
            return
        sweep = Sweep.parse(handle.document(), ACCEPTED)
        units = {axis.name: axis.unit for axis in (*sweep.axes, *sweep.refinements)}
        print_points(handle.runs(state), units)


@app.command()
def fetch(
    id: SweepArgument,
    out: Out,
    overwrite: Overwrite = False,
    every_column: EveryColumn = False,
    whole: Annotated[
        bool, typer.Option("--zip", help="Download everything as OUT/archive.zip: files of the runs, digests too.")
    ] = False,
    url: Url = None,
    key_file: KeyFile = None,
) -> None:
    """Download cube and report of a sweep, or all of its files."""
    with client_of(url, key_file) as client:
        if whole:
            print(client.find_sweep(id).fetch_archive(folder_of(out) / ARCHIVE))
            return
        folder = client.find_sweep(id).fetch(folder_of(out), overwrite=overwrite, every_column=every_column)
    print(f"report: {folder / 'report.html'}")


@app.command("fetch-run")
def fetch_run(
    run: RunArgument,
    out: Annotated[Path, typer.Option(help="Folder for the files of the run.")],
    url: Url = None,
    key_file: KeyFile = None,
) -> None:
    """Download the stored files of a run: result, final state, film, log."""
    with client_of(url, key_file) as client:
        folder = client.fetch_run(client.find_run(run), folder_of(out))
    print(", ".join(sorted(str(file) for file in folder.iterdir())))


@app.command()
def log(run: RunArgument, url: Url = None, key_file: KeyFile = None) -> None:
    """Print the output of the solver in the last attempt of a run, up to now."""
    with client_of(url, key_file) as client:
        print(escaped(client.log(client.find_run(run))), end="")


@app.command()
def cancel(id: SweepArgument, url: Url = None, key_file: KeyFile = None) -> None:
    """Stop a sweep. The results so far are published."""
    with _commanding(id, url, key_file) as handle:
        handle.cancel()


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
    with _commanding(id, url, key_file) as handle:
        handle.retry(verdicts=verdicts)


# "-5" is a number here, not an option.
@app.command(context_settings={"ignore_unknown_options": True})
def priority(
    id: SweepArgument,
    number: Annotated[int, typer.Argument(metavar="N", help="-100 to 100; smaller numbers are computed first.")],
    url: Url = None,
    key_file: KeyFile = None,
) -> None:
    """Change the priority of a sweep; running runs continue."""
    with _commanding(id, url, key_file) as handle:
        handle.prioritise(number)


@app.command()
def pin(id: SweepArgument, url: Url = None, key_file: KeyFile = None) -> None:
    """Keep a sweep: it is not deleted, by hand or by a rule of retention, until `whipple unpin`."""
    with _commanding(id, url, key_file) as handle:
        handle.pin()


@app.command()
def unpin(id: SweepArgument, url: Url = None, key_file: KeyFile = None) -> None:
    """Let a pinned sweep be deleted again."""
    with _commanding(id, url, key_file) as handle:
        handle.pin(pinned=False)


@app.command()
def delete(id: SweepArgument, url: Url = None, key_file: KeyFile = None) -> None:
    """Delete a sweep that has ended, with cube and report; other sweeps keep its runs."""
    with client_of(url, key_file) as client:
        handle = client.find_sweep(id)
        handle.delete()
    print(f"{handle.id} is deleted")


@app.command()
def queue(as_json: Json = False, url: Url = None, key_file: KeyFile = None) -> None:
    """Show the queue: its jobs by state, its leader, and what blocks it."""
    with client_of(url, key_file) as client:
        state = client.queue()
    print_json(state) if as_json else print_queue(state)


@app.command()
def pause(url: Url = None, key_file: KeyFile = None) -> None:
    """Stop starting runs. Running runs continue; sweeps are accepted and published."""
    with client_of(url, key_file) as client:
        print_queue(client.pause())


@app.command()
def resume(url: Url = None, key_file: KeyFile = None) -> None:
    """Start runs again."""
    with client_of(url, key_file) as client:
        print_queue(client.resume())


@contextmanager
def _commanding(id: str, url: str | None, key_file: Path | None) -> "Iterator[SweepHandle]":
    """A sweep that receives a command in the block; its status is printed afterwards."""
    with client_of(url, key_file) as client:
        handle = client.find_sweep(id)
        yield handle
        print_sweep(handle.status())


def _exit_status(ended: "SweepStatus") -> int:
    if ended.state == "failed":
        return FAILURE
    return SUCCESS if ended.counts.get("succeeded") == ended.planned else SOME_FAILED
