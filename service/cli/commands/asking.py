"""What is asked of a service, over HTTP."""

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from service.cli.commands.options import (
    FINE,
    LOCAL,
    SOME_FAILED,
    WRONG,
    KeyFile,
    Out,
    Overwrite,
    RunId,
    SweepFile,
    SweepId,
    Url,
    client_of,
    folder_of,
)

if TYPE_CHECKING:
    from service.client.client import SweepHandle, SweepStatus

app = typer.Typer()

Watch = Annotated[bool, typer.Option("--watch", help="Tell what happens, until it has ended.")]
# "-5" is a number here, not an option.
NUMBERS = {"ignore_unknown_options": True}


@app.command()
def submit(
    file: SweepFile,
    priority: Annotated[
        int, typer.Option(help="Smaller is sooner, -100 to 100; others of larger numbers wait.")
    ] = 0,
    keep: Annotated[
        str, typer.Option(help="Of each run: numbers, also the final state, also the film.")
    ] = "final",
    idempotency_key: Annotated[
        str | None,
        typer.Option(help="Text of your own: the same key with the same sweep is accepted once."),
    ] = None,
    wait: Annotated[bool, typer.Option("--wait", help="Stay until the sweep has ended.")] = False,
    url: Url = LOCAL,
    key_file: KeyFile = None,
) -> None:
    """Give a sweep to a service, and print its id."""
    from service.cli.console import print_sweep

    with client_of(url, key_file) as client:
        handle = client.submit(file, priority=priority, keep=keep, idempotency_key=idempotency_key)
        accepted = handle.status()
        print_sweep(accepted)
        print(
            f"{accepted.planned} runs: {accepted.reused} reused, {accepted.new} new",
            file=sys.stderr,
        )
        if wait:
            raise typer.Exit(_wait(handle, accepted.name))
        print(
            f"watch it with: whipple status {handle.id} --watch --url {client.url}", file=sys.stderr
        )


@app.command()
def status(
    id: Annotated[str | None, typer.Argument(metavar="[ID]", help="A sweep; else all.")] = None,
    watch: Watch = False,
    url: Url = LOCAL,
    key_file: KeyFile = None,
) -> None:
    """Show how far a sweep is, or all sweeps. With --watch: what happens to it, as it happens."""
    from service.cli.console import print_happening, print_sweep, print_sweep_line

    with client_of(url, key_file) as client:
        if id is None:
            for one in client.sweeps():
                print_sweep_line(one)
            return
        handle = client.sweep(id)
        print_sweep(handle.status())
        if watch:
            ended = handle.watch(print_happening)
            print_sweep(ended)
            raise typer.Exit(_status_of(ended))


@app.command()
def runs(
    id: SweepId,
    state: Annotated[
        str | None, typer.Option(help="Only these: queued, running, succeeded, failed, ...")
    ] = None,
    url: Url = LOCAL,
    key_file: KeyFile = None,
) -> None:
    """List the runs of a sweep, each with its state and, where it failed, why."""
    from service.cli.console import print_point

    with client_of(url, key_file) as client:
        handle = client.sweep(id)
        units = _units_of_axes(handle.document())
        for point in handle.runs(state):
            print_point(point, units)


@app.command()
def fetch(
    id: SweepId,
    out: Out,
    overwrite: Overwrite = False,
    url: Url = LOCAL,
    key_file: KeyFile = None,
) -> None:
    """Download cube and report of a sweep."""
    with client_of(url, key_file) as client:
        folder = client.sweep(id).fetch(folder_of(out), overwrite=overwrite)
    print(f"look at {folder / 'report.html'}")


@app.command("fetch-run")
def fetch_run(
    run: RunId,
    out: Annotated[Path, typer.Option(help="Folder for what is kept of the run.")],
    url: Url = LOCAL,
    key_file: KeyFile = None,
) -> None:
    """Download what is kept of a run: result, final state, film, log."""
    with client_of(url, key_file) as client:
        folder = client.fetch_run(run, folder_of(out))
    print(", ".join(sorted(str(file) for file in folder.iterdir())))


@app.command()
def log(run: RunId, url: Url = LOCAL, key_file: KeyFile = None) -> None:
    """Print what the solver said in the last attempt of a run; of a running one, until now."""
    with client_of(url, key_file) as client:
        print(client.log(run), end="")


@app.command()
def cancel(id: SweepId, url: Url = LOCAL, key_file: KeyFile = None) -> None:
    """Stop a sweep. What was computed until now is published."""
    with _told(id, url, key_file) as handle:
        handle.cancel()


@app.command()
def retry(
    id: SweepId,
    verdicts: Annotated[
        bool, typer.Option("--verdicts", help="Also what the solver gave up; it will again.")
    ] = False,
    url: Url = LOCAL,
    key_file: KeyFile = None,
) -> None:
    """Compute again what an accident or a cancel ended, then publish again."""
    with _told(id, url, key_file) as handle:
        handle.retry(verdicts=verdicts)


@app.command(context_settings=NUMBERS)
def priority(
    id: SweepId,
    number: Annotated[int, typer.Argument(metavar="N", help="Smaller is sooner, -100 to 100.")],
    url: Url = LOCAL,
    key_file: KeyFile = None,
) -> None:
    """Let a sweep come sooner or later; runs under way go on."""
    with _told(id, url, key_file) as handle:
        handle.prioritise(number)


@app.command()
def delete(id: SweepId, url: Url = LOCAL, key_file: KeyFile = None) -> None:
    """Forget a sweep that has ended, with cube and report; its runs stay for others."""
    with client_of(url, key_file) as client:
        client.sweep(id).delete()
    print(f"{id} is deleted")


@app.command()
def queue(url: Url = LOCAL, key_file: KeyFile = None) -> None:
    """Show the queue as a whole: what is in it, who works through it, and what hinders."""
    from service.cli.console import print_queue

    with client_of(url, key_file) as client:
        print_queue(client.queue())


@app.command()
def pause(url: Url = LOCAL, key_file: KeyFile = None) -> None:
    """Begin no more runs. Those under way go on; sweeps are accepted and published."""
    from service.cli.console import print_queue

    with client_of(url, key_file) as client:
        print_queue(client.pause())


@app.command()
def resume(url: Url = LOCAL, key_file: KeyFile = None) -> None:
    """Begin runs again."""
    from service.cli.console import print_queue

    with client_of(url, key_file) as client:
        print_queue(client.resume())


@contextmanager
def _told(id: str, url: str, key_file: Path | None) -> "Iterator[SweepHandle]":
    """A sweep for an order, and how it stands after that."""
    from service.cli.console import print_sweep

    with client_of(url, key_file) as client:
        handle = client.sweep(id)
        yield handle
        print_sweep(handle.status())


def _units_of_axes(document: Mapping[str, Any]) -> dict[str, str | None]:
    """The SI unit of each axis of an accepted sweep, and of what each point is refined by."""
    from studies.sweeps.sweep import ACCEPTED, Sweep

    sweep = Sweep.parse(document, ACCEPTED)
    return {axis.name: axis.unit for axis in (*sweep.axes, *sweep.refinements)}


def _wait(handle: "SweepHandle", name: str) -> int:
    """Stay until a sweep has ended, say how, and return the exit status."""
    from service.cli.console import print_sweep, watching

    with watching(name) as tell:
        ended = handle.wait(on_progress=tell)
    print_sweep(ended)
    return _status_of(ended)


def _status_of(ended: "SweepStatus") -> int:
    if ended.state == "failed":
        return WRONG
    return FINE if ended.counts.get("succeeded") == ended.planned else SOME_FAILED
