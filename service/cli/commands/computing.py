"""Sweeps on this machine, without a service."""

import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict, Unpack

import typer

from service.cli.commands import LOCAL, Commands
from service.cli.console import print_warnings
from service.cli.options import (
    Accuracy,
    EveryColumn,
    KeepOption,
    Laws,
    Out,
    Overwrite,
    SweepFile,
    Threads,
    document_of,
    exit_status,
    folder_of,
    settings_of,
)
from service.cli.progress import showing_progress
from studies.quantities.parameters import Plain

if TYPE_CHECKING:
    from service.cli.local import Finished
    from service.workers.warm import WarmProcess

app = typer.Typer()
COMMANDS = Commands("computing", LOCAL, app)

PUBLICATION = ("studies.reports.publish", "studies.reports.page")


@app.command()
def sweep(
    file: SweepFile,
    out: Out,
    overwrite: Overwrite = False,
    threads: Threads = None,
    law: Laws = None,
    accuracy: Accuracy = None,
    keep: KeepOption = "final",
    every_column: EveryColumn = False,
) -> None:
    """Compute a sweep on this machine, without a service. Repeated, it resumes.

    With --keep film, films are in runs/RUN/film.npz of the folder.
    """
    from service.workers.warm import preloading

    # A child process imports what publishing needs (1 s) while this one imports what the queue needs (1 s).
    with preloading(*PUBLICATION) as ready:
        from service.settings import Settings
        from studies.sweeps.reading import SweepLimits
        from studies.sweeps.sweep import Sweep

        document = document_of(file, law, accuracy)
        print_warnings(Sweep.parse(document, SweepLimits(max_runs=Settings().max_runs)))
        options: RunOptions = {"overwrite": overwrite, "keep": keep, "every_column": every_column, "ready": ready}
        status = compute(document, file.stem, folder_of(out), threads, **options)
    raise typer.Exit(status)


class RunOptions(TypedDict, total=False):
    """Options of ``service.cli.local.run_sweep``."""

    overwrite: bool
    keep: str
    every_column: bool
    ready: "list[WarmProcess]"


def compute(
    sweep: Mapping[str, Plain], name: str, folder: Path, threads: str | None = None, **options: Unpack[RunOptions]
) -> int:
    """Compute a sweep into a folder as ``run_sweep`` does, print the outcome, and return the exit status."""
    from service.cli.local import STORE_OF_FOLDER, run_sweep

    begin = time.perf_counter()
    settings = settings_of(data=folder / STORE_OF_FOLDER, threads=threads)
    with showing_progress(name) as show:
        finished = run_sweep(sweep, folder, progress=show, settings=settings, **options)
    return say_outcome(name, finished, begin)


def say_outcome(name: str, finished: "Finished", begin: float) -> int:
    """Print what became of a sweep since a time of the counter of seconds, and return the exit status."""
    seconds = time.perf_counter() - begin
    print(f"{name}: {finished.sweep.tally} in {seconds:.1f} s; report: {finished.folder / 'report.html'}", flush=True)
    if headline := json.loads((finished.folder / "report.json").read_text("utf-8"))["headline"]:
        print(f"  {headline}", flush=True)
    return exit_status(finished.sweep)
