"""The command ``whipple``: sweeps on this machine, the service, and the same sweeps given to a service.

Exit status: 0 all fine, 1 something went wrong, 2 the input is refused, 3 some runs failed.
"""

import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NoReturn

import typer

from solver.errors import WhippleError
from studies.errors import Finding, InvalidInput

if TYPE_CHECKING:
    from service.client import Client, SweepStatus
    from service.settings import Settings

FINE, WRONG, REFUSED, SOME_FAILED = 0, 1, 2, 3
DEMO = ("holes", "craters")
WARMUP = "from studies.run import warmup; warmup()"

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
        _print_findings(error)
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
    print(f"kernels: ready after {cold:.1f} s; once they are on disk, {warm:.1f} s", flush=True)
    begin, statuses = time.perf_counter(), []
    for name in DEMO:
        statuses.append(_compute(read_yaml(examples.text(name), name), folder / name))
    sweeps = time.perf_counter() - begin
    print(f"wall time: {sweeps + cold:.1f} s cold (kernels made), {sweeps + warm:.1f} s warm")
    for name in DEMO:
        print(f"look at {folder / name / 'report.html'}")
    raise typer.Exit(max(statuses))


@app.command()
def sweep(file: SweepFile, out: Out) -> None:
    """Compute a sweep on this machine, without a service. Run again, it resumes."""
    from studies.sweep_document import read_sweep_file

    raise typer.Exit(_compute(read_sweep_file(file), _folder(out)))


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
    with _client(url) as client:
        handle = client.submit(file)
        _print_status(handle.status())
        print(f"watch it with: whipple status {handle.id} --url {client.url}", file=sys.stderr)


@app.command()
def status(
    id: Annotated[str | None, typer.Argument(metavar="[ID]", help="A sweep; else all.")] = None,
    url: Url = LOCAL,
) -> None:
    """Show how far a sweep is, or all sweeps."""
    with _client(url) as client:
        if id is not None:
            _print_status(client.sweep(id).status())
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
    with _client(url) as client:
        _print_status(client.sweep(id).cancel())


@app.command()
def warmup() -> None:
    """Compile the kernels into their cache, so that no run has to."""
    print(f"kernels: ready after {_seconds_of(_compile_kernels):.1f} s")


@app.command()
def version() -> None:
    """Print the version."""
    from service.version import version

    print(version())


def _compute(document: dict[str, Any], folder: Path) -> int:
    """Compute a sweep into a folder with a progress bar, and return the exit status."""
    raise NotImplementedError


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


def _seconds_of(work: Any) -> float:
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


def _print_findings(error: InvalidInput) -> None:
    print("whipple: the input is refused", file=sys.stderr)
    for finding in error.findings:
        print(f"  {finding.field}", file=sys.stderr)
        for word in ("value", "limit", "cure"):
            print(f"    {word:<6} {getattr(finding, word)}", file=sys.stderr)


def _print_status(one: "SweepStatus") -> None:
    counts = ", ".join(f"{count} {state}" for state, count in one.counts.items() if count)
    print(f"{one.id}  {one.name}: {one.state}, {one.progress:.0%} ({counts})")
    if one.reason:
        print(f"  {one.reason}")
    if one.eta_seconds is not None:
        from service.console import duration

        print(f"  {duration(one.eta_seconds)} left")
