"""The command ``whipple``: sweeps on this machine, the service, and the same sweeps given to a service.

Exit status: 0 all fine, 1 something went wrong, 2 the input is refused, 3 some runs failed.
"""

import json
import subprocess
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from solver.errors import WhippleError
from studies.errors import Finding, InvalidInput

if TYPE_CHECKING:
    from service.client import Client
    from service.settings import Settings

FINE, WRONG, REFUSED, SOME_FAILED = 0, 1, 2, 3
DEMO = ("holes", "craters")
WARMUP = "from studies.run import warm_up; warm_up()"

app = typer.Typer(
    name="whipple",
    help="Hypervelocity impact: sweeps in, cubes and law reports out.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

Out = Annotated[Path, typer.Option(help="Folder for cube.nc, report.html and report.json.")]
Url = Annotated[str, typer.Option(envvar="WHIPPLE_SERVICE", help="Address of the service.")]
SweepFile = Annotated[Path, typer.Argument(metavar="FILE", help="A sweep document (YAML or JSON).")]
SweepId = Annotated[str, typer.Argument(metavar="ID", help="What submit printed.")]
LOCAL = "http://127.0.0.1:8000"


def main() -> NoReturn:
    """Run the command; whatever goes wrong is said in words."""
    try:
        app()
    except InvalidInput as error:
        from service.console import print_findings

        print_findings(error)
        sys.exit(REFUSED)
    except WhippleError as error:
        print(f"whipple: {error}", file=sys.stderr)
    sys.exit(WRONG)


@app.command()
def demo(out: Out = Path("demo")) -> None:
    """Compute the two example sweeps: holes in thin plates, craters in a thick block."""
    from studies import examples
    from studies.sweep_document import read_yaml

    folder = _folder(out)
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
def sweep(file: SweepFile, out: Out) -> None:
    """Compute a sweep on this machine, without a service. Run again, it resumes."""
    raise typer.Exit(_compute(file, file.stem, _folder(out)))


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
def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on.")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; 0 takes a free one.")] = None,
    data: Annotated[Path | None, typer.Option(help="Folder of database and results.")] = None,
) -> None:
    """Start the service: interface, queue and local workers. What is not given comes from WHIPPLE_*."""
    from service.serve import serve as run

    run(_settings(host=host, port=port, data=data))


@app.command()
def submit(file: SweepFile, url: Url = LOCAL) -> None:
    """Give a sweep to a service, and print its id."""
    from service.console import print_sweep

    with _client(url) as client:
        handle = client.submit(file)
        print_sweep(handle.status())
        print(f"watch it with: whipple status {handle.id} --url {client.url}", file=sys.stderr)


@app.command()
def status(
    id: Annotated[str | None, typer.Argument(metavar="[ID]", help="A sweep; else all.")] = None,
    url: Url = LOCAL,
) -> None:
    """Show how far a sweep is, or all sweeps."""
    from service.console import print_sweep

    with _client(url) as client:
        if id is not None:
            print_sweep(client.sweep(id).status())
            return
        for one in client.sweeps():
            print(
                f"{one.id}  {one.state:<10}  {one.progress:>4.0%}  {one.planned:>6} runs  {one.name}"
            )


@app.command()
def fetch(id: SweepId, out: Out, url: Url = LOCAL) -> None:
    """Download cube and report of a sweep."""
    with _client(url) as client:
        folder = client.sweep(id).fetch(_folder(out))
    print(f"look at {folder / 'report.html'}")


@app.command()
def cancel(id: SweepId, url: Url = LOCAL) -> None:
    """Stop a sweep. What was computed until now is published."""
    from service.console import print_sweep

    with _client(url) as client:
        print_sweep(client.sweep(id).cancel())


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


def _compute(sweep: "Mapping[str, Any] | Path", name: str, folder: Path) -> int:
    """Compute a sweep into a folder, say how it went, and return the exit status."""
    from service.console import in_words, watching
    from service.local import run_sweep

    begin = time.perf_counter()
    with watching(name) as tell:
        finished = run_sweep(sweep, folder, progress=tell)
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


def _folder(out: Path) -> Path:
    """The folder, made if it is missing; raises InvalidInput."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        cure = f"choose another one: {error.strerror}"
        raise InvalidInput(
            [Finding("--out", str(out), "a folder that can be made", cure)]
        ) from None
    return out


def _client(url: str) -> "Client":
    from service.client import Client

    return Client(url)


def _settings(**given: Any) -> "Settings":
    """Settings from the environment and the options that were given; raises InvalidInput."""
    from pydantic import ValidationError

    from service.settings import Settings

    try:
        return Settings(**{name: value for name, value in given.items() if value is not None})
    except ValidationError as error:
        raise InvalidInput(
            Finding(
                ".".join(map(str, one["loc"])),
                str(one["input"]),
                one["msg"],
                "correct the option, or WHIPPLE_* in the environment",
            )
            for one in error.errors()
        ) from None
