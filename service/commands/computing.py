"""Sweeps on this machine, without a service; and what the solver says of itself."""

import json
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from service.commands.options import FINE, SOME_FAILED, WRONG, Out, Overwrite, SweepFile, folder_of
from solver.errors import WhippleError
from studies.errors import Finding, InvalidInput

app = typer.Typer()

DEMO = ("holes", "craters")
WARMUP = "from studies.run import warm_up; warm_up()"


@app.command()
def demo(out: Out = Path("demo")) -> None:
    """Compute the two example sweeps: holes in thin plates, craters in a thick block."""
    from studies import examples
    from studies.sweep_document import read_yaml

    folder = folder_of(out)
    cold = _seconds_of(_compile_kernels)
    warm = _seconds_of(_compile_kernels)
    print(f"kernels: ready after {cold:.1f} s, from disk after {warm:.1f} s", flush=True)
    begin = time.perf_counter()
    documents = {name: read_yaml(examples.text(name), name) for name in DEMO}
    statuses = [_compute(document, name, folder / name) for name, document in documents.items()]
    sweeps = time.perf_counter() - begin
    print(f"wall time: {sweeps + cold:.1f} s cold (as just now), {sweeps + warm:.1f} s warm")
    raise typer.Exit(max(statuses))


@app.command()
def sweep(file: SweepFile, out: Out, overwrite: Overwrite = False) -> None:
    """Compute a sweep on this machine, without a service. Run again, it resumes."""
    raise typer.Exit(_compute(file, file.stem, folder_of(out), overwrite=overwrite))


@app.command()
def estimate(file: SweepFile) -> None:
    """Say what a sweep would cost, as it is and at each accuracy. Nothing is computed."""
    from service.console import print_cost
    from service.settings import Settings
    from studies.cost import cost_of, presets_of
    from studies.sweep import Sweep, SweepLimits
    from studies.sweep_document import read_sweep_file

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
def warmup() -> None:
    """Compile the kernels into their cache, so that no run has to."""
    print(f"kernels: ready after {_seconds_of(_compile_kernels):.1f} s")


@app.command()
def version() -> None:
    """Print the version."""
    from service.version import version

    print(version())


def _compute(
    sweep: "Mapping[str, Any] | Path", name: str, folder: Path, *, overwrite: bool = False
) -> int:
    """Compute a sweep into a folder, say how it went, and return the exit status."""
    from service.console import in_words, watching
    from service.local import run_sweep

    begin = time.perf_counter()
    with watching(name) as tell:
        finished = run_sweep(sweep, folder, progress=tell, overwrite=overwrite)
    seconds = time.perf_counter() - begin
    print(
        f"{name}: {in_words(finished.counts)} in {seconds:.1f} s; look at {folder / 'report.html'}"
    )
    all_fine = finished.counts["succeeded"] == finished.sweep.planned
    return FINE if all_fine else SOME_FAILED


def _compile_kernels() -> None:
    """In a process of its own: this one never loads the solver."""
    child = subprocess.run(
        [sys.executable, "-c", WARMUP],
        check=False,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
    )
    if child.returncode:
        raise WhippleError(f"the kernels cannot be compiled: {child.stderr.strip()}")


def _seconds_of(work: Callable[[], None]) -> float:
    begin = time.perf_counter()
    work()
    return time.perf_counter() - begin
