"""The command ``whipple continue``."""

import json
from pathlib import Path
from typing import Annotated

import typer

from service.cli.commands import LOCAL, Commands
from service.cli.commands.computing import compute
from service.cli.options import EveryColumn, KeepOption, Threads
from studies.quantities.files import write_text
from studies.quantities.findings import refusal

app = typer.Typer()
COMMANDS = Commands("growing", LOCAL, app)


@app.command("continue")
def continue_growing(
    folder: Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder of `whipple sweep --out`.")],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FILE", help="Write the sweep (JSON), to submit it to a service."),
    ] = None,
    threads: Threads = None,
    keep: KeepOption = "final",
    every_column: EveryColumn = False,
) -> None:
    """Compute the runs of a folder that were still growing at their latest end anew, with twice that end.

    All other runs are kept, and cube and report are made again. Nothing goes on from a checkpoint: none is kept of a
    run that has ended, and the latest end is part of what a run is. Repeated, it doubles the ends that were too early.
    """
    from service.cli.local import STORE_OF_FOLDER
    from studies.growing.later import with_later_ends

    if output is None and not (folder / STORE_OF_FOLDER).is_dir():
        cure = "give the folder of a sweep that was computed on this machine; --output FILE is for those of a service"
        raise refusal("FOLDER", str(folder), "a folder of `whipple sweep --out`", cure)
    sweep, points = with_later_ends(folder)
    if not points:
        print(f"{sweep.name}: no run was still growing at its latest end")
        return
    print(f"{sweep.name}: {points} points get twice their latest end", flush=True)
    if output is not None:
        write_text(output, json.dumps(sweep.document(), indent=1, ensure_ascii=False) + "\n")
        print(f"written: {output}; compute it with: whipple submit {output}")
        return
    raise typer.Exit(
        compute(sweep.document(), sweep.name, folder, threads=threads, keep=keep, every_column=every_column)
    )
