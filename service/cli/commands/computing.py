"""Sweeps on this machine, without a service; and what the solver says of itself."""

import json
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from service.cli.commands.options import (
    FINE,
    SOME_FAILED,
    WRONG,
    Out,
    Overwrite,
    SweepFile,
    Threads,
    folder_of,
    settings_of,
)
from solver.errors import WhippleError
from studies.values.errors import Finding, InvalidInput

app = typer.Typer()

DEMO = ("holes", "craters")
KERNELS = ("-m", "studies.sweeps.kernels")  # what compiles them, after the interpreter


@app.command()
def demo(out: Out = Path("demo"), threads: Threads = None) -> None:
    """Compute the two example sweeps: holes in thin plates, craters in a thick block."""
    from studies import examples
    from studies.sweeps.document import read_yaml

    folder = folder_of(out)
    begin = time.perf_counter()
    documents = {name: read_yaml(examples.text(name), name) for name in DEMO}
    _compile_kernels(list(documents.values()))
    statuses = [
        _compute(document, name, folder / name, threads=threads)
        for name, document in documents.items()
    ]
    print(f"wall time: {time.perf_counter() - begin:.1f} s")
    raise typer.Exit(max(statuses))


@app.command()
def sweep(file: SweepFile, out: Out, overwrite: Overwrite = False, threads: Threads = None) -> None:
    """Compute a sweep on this machine, without a service. Run again, it resumes."""
    raise typer.Exit(
        _compute(file, file.stem, folder_of(out), overwrite=overwrite, threads=threads)
    )


@app.command()
def export(
    film: Annotated[
        Path, typer.Argument(metavar="FILM", help="The film.npz of a run, or a folder with it.")
    ],
    vtk: Annotated[Path, typer.Option(help="Folder for film.pvd and a VTU file for each frame.")],
) -> None:
    """Write the film of a run as files that ParaView opens."""
    from studies.films.film_dataset import open_film
    from studies.films.film_vtk import bodies, export_vtk

    with open_film(film) as opened:
        listed = export_vtk(opened, folder_of(vtk))
        names = ", ".join(f"{number} {name}" for number, name in enumerate(bodies(opened)) if name)
        print(f"{opened.sizes['time']} frames, bodies {names}; open {listed}")


@app.command()
def estimate(file: SweepFile) -> None:
    """Say what a sweep would cost, as it is and at each accuracy. Nothing is computed."""
    from service.cli.console import print_cost
    from service.records.settings import Settings
    from studies.sweeps.cost import cost_of, presets_of
    from studies.sweeps.document import read_sweep_file
    from studies.sweeps.sweep import Sweep, SweepLimits

    most = Settings().max_runs
    asked = Sweep.parse(read_sweep_file(file), SweepLimits(max_runs=most))
    print_cost(asked.name, cost_of(asked), presets_of(asked, most))


@app.command()
def validate(
    name: Annotated[str | None, typer.Argument(metavar="[NAME]", help="A case; else all.")] = None,
    verification: Annotated[
        bool, typer.Option("--verification", help="Problems with an exact answer.")
    ] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Cases of a few seconds only.")] = False,
    json_file: Annotated[
        Path | None, typer.Option("--json", metavar="FILE", help="Write the rows there too.")
    ] = None,
) -> None:
    """Solve problems with a known answer; prints expected, got, error and verdict, and fails when one fails."""
    from studies.verification import names, verify

    if not verification:
        cure = "add --verification"
        raise InvalidInput([Finding("validate", "no kind of cases", "--verification", cure)])
    rows = []
    for one in verify([name] if name else names(quick=quick)):
        print(f"{one.case} | {one.row}", flush=True)
        rows.append(one)
    if json_file:
        document = {"verification": [one.as_json() for one in rows]}
        json_file.write_text(json.dumps(document, indent=2, allow_nan=False) + "\n", "utf-8")
    failed = sum(one.row.passed is False for one in rows)
    gated = sum(one.row.passed is not None for one in rows)
    print(f"{gated - failed} passed, {failed} failed, {len(rows) - gated} reported")
    raise typer.Exit(WRONG if failed or not rows else FINE)


@app.command()
def warm(
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            metavar="[SWEEP.yaml ...]", help="Sweeps; else all examples, by both recipes."
        ),
    ] = None,
) -> None:
    """Compile the kernels of sweeps into their cache, so that no run has to."""
    _compile_kernels([_document(file) for file in files] if files else _examples())


def _document(file: Path) -> Mapping[str, Any]:
    from studies.sweeps.document import read_sweep_file
    from studies.sweeps.sweep import Sweep

    return Sweep.parse(read_sweep_file(file)).document()


def _examples() -> Sequence[Mapping[str, Any]]:
    from studies import examples
    from studies.sweeps.document import read_yaml

    documents = [read_yaml(examples.text(name), name) for name in examples.names()]
    thesis = [{**one, "fixed": {**one.get("fixed", {}), "recipe": "thesis"}} for one in documents]
    return documents + thesis


@app.command()
def version() -> None:
    """Print the version."""
    from service.records.version import version

    print(version())


def _compute(
    sweep: "Mapping[str, Any] | Path",
    name: str,
    folder: Path,
    *,
    overwrite: bool = False,
    threads: str | None = None,
) -> int:
    """Compute a sweep into a folder, say how it went, and return the exit status."""
    from service.cli.console import in_words, watching
    from service.cli.local import STORE_OF_FOLDER, run_sweep

    begin = time.perf_counter()
    settings = settings_of(data=folder / STORE_OF_FOLDER, threads=threads)
    with watching(name) as tell:
        finished = run_sweep(sweep, folder, progress=tell, settings=settings, overwrite=overwrite)
    seconds = time.perf_counter() - begin
    print(
        f"{name}: {in_words(finished.counts)} in {seconds:.1f} s; look at {folder / 'report.html'}"
    )
    all_fine = finished.counts["succeeded"] == finished.sweep.planned
    return FINE if all_fine else SOME_FAILED


def _compile_kernels(sweeps: Sequence[Mapping[str, Any]]) -> None:
    """In processes of their own, as this one never loads the solver; prints kinds and seconds."""
    begin = time.perf_counter()
    child = subprocess.run(
        [sys.executable, *KERNELS],
        check=False,
        input=json.dumps(list(sweeps)),
        capture_output=True,
        text=True,
    )
    if child.returncode:
        raise WhippleError(f"the kernels cannot be compiled: {child.stderr.strip()}")
    seconds = time.perf_counter() - begin
    print(f"kernels: {child.stdout.strip()} kinds ready after {seconds:.1f} s", flush=True)
