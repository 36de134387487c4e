"""Sweeps on this machine, without a service; estimates, kernels, films."""

import json
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from service.cli.commands.options import (
    SOME_FAILED,
    SUCCESS,
    Json,
    KeepOption,
    Laws,
    Out,
    Overwrite,
    SweepFile,
    Threads,
    document_of,
    folder_of,
    settings_of,
)
from solver.errors import WhippleError
from studies.quantities.findings import Finding, InvalidInput

if TYPE_CHECKING:
    from service.workers.warm import WarmProcess

app = typer.Typer()

Full = Annotated[
    bool, typer.Option("--full", help="The sweeps over more thicknesses and on finer grids: half an hour.")
]

PUBLICATION = ("studies.reports.publish", "studies.reports.page")
DEMO = ("holes", "aluminium", "sphere", "craters")
FULL = ("holes-full", "aluminium-full", "craters-full")
KERNELS = ("-m", "studies.sweeps.kernels")  # arguments of the interpreter that compiles them


@app.command()
def demo(out: Out = Path("demo"), threads: Threads = None, full: Full = False) -> None:
    """Compute the example sweeps: holes in copper and aluminium, a measured crater, craters in copper."""
    from studies import examples
    from studies.sweeps.document import read_yaml

    folder = folder_of(out)
    begin = time.perf_counter()
    names = FULL if full else DEMO
    documents = {name: read_yaml(examples.text(name), name) for name in names}
    _compile_kernels(list(documents.values()))
    statuses = [compute(document, name, folder / name, threads=threads) for name, document in documents.items()]
    print(f"wall time: {time.perf_counter() - begin:.1f} s")
    raise typer.Exit(max(statuses))


@app.command()
def sweep(
    file: SweepFile,
    out: Out,
    overwrite: Overwrite = False,
    threads: Threads = None,
    law: Laws = None,
    keep: KeepOption = "final",
) -> None:
    """Compute a sweep on this machine, without a service. Repeated, it resumes.

    With --keep film, films are in runs/RUN/film.npz of the folder.
    """
    from service.workers.warm import preloading

    # A child process imports what publishing needs (1 s) while this one imports what the queue needs (1 s).
    with preloading(*PUBLICATION) as ready:
        from service.cli.console import print_warnings
        from service.settings import Settings
        from studies.sweeps.reading import SweepLimits
        from studies.sweeps.sweep import Sweep

        document = document_of(file, law)
        print_warnings(Sweep.parse(document, SweepLimits(max_runs=Settings().max_runs)))
        status = compute(
            document, file.stem, folder_of(out), overwrite=overwrite, threads=threads, keep=keep, ready=ready
        )
    raise typer.Exit(status)


@app.command()
def export(
    film: Annotated[Path, typer.Argument(metavar="FILM", help="film.npz of a run, or its folder.")],
    vtk: Annotated[Path, typer.Option(help="Folder for film.pvd and one VTU file per frame.")],
) -> None:
    """Convert the film of a run to VTK files for ParaView."""
    from studies.films.film_dataset import open_film
    from studies.films.film_vtk import bodies, export_vtk
    from studies.sweeps.document import no_such_file

    if not film.exists():
        raise no_such_file(film, example="give the film.npz of a run that kept its film, or its folder")
    with open_film(film) as opened:
        listed = export_vtk(opened, folder_of(vtk))
        names = ", ".join(f"{number} {name}" for number, name in enumerate(bodies(opened)) if name)
        print(f"{opened.sizes['time']} frames, bodies {names}; open {listed}")


@app.command()
def plot(
    cube: Annotated[Path, typer.Argument(metavar="CUBE", help="cube.nc of a sweep, or its folder.")],
    out: Annotated[Path, typer.Option(help="Folder for the files, one for each figure.")] = Path(),
    format: Annotated[str, typer.Option(metavar="png|svg|pdf", help="Format of the files.")] = "png",
) -> None:
    """Draw the figures of the report of a cube into files."""
    from studies.reports.publish import FORMATS, draw_figures
    from studies.sweeps.document import no_such_cube

    formats = [name for name in FORMATS if name == format.lower()]
    if not formats:
        raise InvalidInput([Finding("--format", format, ", ".join(FORMATS), "write one of these")])
    if not cube.exists():
        raise no_such_cube(cube)
    for file in draw_figures(cube, folder_of(out), formats[0]):
        print(file)


@app.command()
def estimate(file: SweepFile, as_json: Json = False) -> None:
    """Estimate the cost of a sweep, as it is and at each accuracy. Nothing is computed."""
    from dataclasses import asdict

    from service.cli.console import print_cost, print_json, print_warnings
    from service.settings import Settings
    from studies.sweeps.cost import cost_of, presets_of
    from studies.sweeps.document import read_sweep_file
    from studies.sweeps.reading import SweepLimits
    from studies.sweeps.sweep import Sweep

    limit = Settings().max_runs
    sweep = Sweep.parse(read_sweep_file(file), SweepLimits(max_runs=limit))
    cost, presets = cost_of(sweep), list(presets_of(sweep, limit))
    if as_json:
        print_json({"name": sweep.name, **asdict(cost), "presets": [asdict(each) for each in presets]})
    else:
        print_cost(sweep.name, cost, presets)
    print_warnings(sweep)


@app.command()
def warm(
    files: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[SWEEP.yaml ...]", help="Sweep files; by default all examples, with both recipes."),
    ] = None,
) -> None:
    """Compile the kernels of sweeps into the cache, before the first run needs them."""
    from studies import examples
    from studies.sweeps.document import read_sweep_file, read_yaml
    from studies.sweeps.sweep import Sweep

    if files:
        _compile_kernels([Sweep.parse(read_sweep_file(file)).document() for file in files])
        return
    documents = [read_yaml(examples.text(name), name) for name in examples.names()]
    thesis = [{**document, "fixed": {**document.get("fixed", {}), "recipe": "thesis"}} for document in documents]
    _compile_kernels(documents + thesis)


def compute(
    sweep: "Mapping[str, Any] | Path",
    name: str,
    folder: Path,
    *,
    overwrite: bool = False,
    threads: str | None = None,
    keep: str = "final",
    ready: "list[WarmProcess] | None" = None,
) -> int:
    """Compute a sweep into a folder, print the outcome, and return the exit status.

    ``ready`` are processes that were started before.
    """
    from service.cli.local import STORE_OF_FOLDER, run_sweep
    from service.client.progress import showing_progress

    begin = time.perf_counter()
    settings = settings_of(data=folder / STORE_OF_FOLDER, threads=threads)
    with showing_progress(name) as show:
        finished = run_sweep(
            sweep, folder, progress=show, settings=settings, overwrite=overwrite, keep=keep, ready=ready
        )
    seconds = time.perf_counter() - begin
    print(f"{name}: {finished.sweep.tally} in {seconds:.1f} s; report: {folder / 'report.html'}")
    if headline := _headline(folder):
        print(f"  {headline}")
    has_all = finished.counts["succeeded"] == finished.sweep.planned
    return SUCCESS if has_all else SOME_FAILED


def _headline(folder: Path) -> str:
    """The headline of a report; empty where an earlier version made the report."""
    report = json.loads((folder / "report.json").read_text("utf-8"))
    return str(report.get("headline", ""))


def _compile_kernels(sweeps: Sequence[Mapping[str, Any]]) -> None:
    """Compile kernels in a child process, because this one never loads the solver; print kinds and seconds."""
    begin = time.perf_counter()
    child = subprocess.run(
        [sys.executable, *KERNELS], check=False, input=json.dumps(list(sweeps)), capture_output=True, text=True
    )
    if child.returncode:
        raise WhippleError(f"the kernels cannot be compiled: {child.stderr.strip()}")
    seconds = time.perf_counter() - begin
    print(f"kernels: {child.stdout.strip()} kinds ready after {seconds:.1f} s", flush=True)
