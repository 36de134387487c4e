"""The examples that ship: questions answered, and sweeps computed."""

import json
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

from service.cli.commands import LOCAL, Commands
from service.cli.commands.computing import say_outcome
from service.cli.options import Out, Threads, folder_of, settings_of
from service.cli.progress import showing_progress
from solver.registry import entries
from studies.quantities.parameters import Plain
from studies.sweeps import examples
from studies.sweeps.document import read_yaml

app = typer.Typer()
COMMANDS = Commands("demo", LOCAL, app)

Examples = Annotated[
    list[str] | None, typer.Argument(metavar="[EXAMPLE ...]", help="Examples that ship; by default holes and craters.")
]
EveryExample = Annotated[bool, typer.Option("--all", help="Every example that ships.")]

DEMO = ("holes", "craters")  # which share their kernels


@app.command()
def demo(
    names: Examples = None,
    out: Out = Path("demo"),
    threads: Threads = None,
    every_example: EveryExample = False,
    warm: Annotated[
        bool,
        typer.Option("--warm", help="Only compile the kernels of the examples, with both recipes, into the cache."),
    ] = False,
) -> None:
    """Answer the questions that ship, and compute example sweeps: holes and craters, or those that are named."""
    from service.cli.local import STORE_OF_FOLDER, run_sweeps

    begin = time.perf_counter()
    chosen = examples.names() if every_example or (warm and not names) else names or DEMO
    documents = {name: read_yaml(examples.text(name), name) for name in chosen}
    if warm:
        _compile_kernels([*documents.values()], begin)
        return
    folder = folder_of(out)
    for part in entries("service.cli.commands", "COMMANDS").values():
        if part.demo is not None:
            part.demo(folder)
    settings = settings_of(data=folder / STORE_OF_FOLDER, threads=threads)
    sweeps = run_sweeps(documents, folder, showing=showing_progress, settings=settings)
    statuses = [say_outcome(name, finished, begin) for name, finished in sweeps]
    print(f"wall time: {time.perf_counter() - begin:.1f} s")
    raise typer.Exit(max(statuses))


def _compile_kernels(documents: Sequence[Mapping[str, Plain]], begin: float) -> None:
    """Compile the kernels of sweeps, with both recipes, before the first run needs them."""
    thesis = [
        {**document, "fixed": {**fixed, "recipe": "thesis"}}
        for document in documents
        if isinstance(fixed := document.get("fixed", {}), Mapping)
    ]
    # In a child process, because this one never loads the solver.
    child = subprocess.run(
        [sys.executable, "-m", "studies.sweeps.kernels"],
        check=True,
        input=json.dumps([*documents, *thesis]),
        stdout=subprocess.PIPE,
        text=True,
    )
    seconds = time.perf_counter() - begin
    print(f"kernels: {child.stdout.strip()} kinds ready after {seconds:.1f} s", flush=True)
