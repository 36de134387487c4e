"""Published problems, computed here and compared."""

import json
from collections import Counter
from pathlib import Path
from typing import Annotated, Literal

import typer

from service.cli.commands import LOCAL, Commands
from service.cli.options import FAILURE, SUCCESS, Json, Threads, folder_of, settings_of
from service.cli.progress import showing_progress

app = typer.Typer()
COMMANDS = Commands("cases", LOCAL, app, place=3)

Cases = Annotated[list[str] | None, typer.Argument(metavar="[CASE ...]", help="Cases; all without one.")]
DetailLevel = Annotated[  # as in ``studies.cases.validation``, whose import takes long
    Literal["quick", "thesis", "fine"],
    typer.Option("--level", help="Coarse grids; the meshes of the sources; or three grids."),
]


@app.command()
def validate(
    cases: Cases = None,
    level: DetailLevel = "quick",
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for page, cubes and reports.")] = Path("validation"),
    threads: Threads = None,
    listing: Annotated[bool, typer.Option("--list", help="Print the cases alone.")] = False,
    as_json: Json = False,
) -> None:
    """Compute published problems, and compare. Repeated, it resumes."""
    from service.cases.validation import STORE, selected, validated

    chosen = selected(cases or [])
    if listing:
        for case in chosen:
            print(f"{case.name}: {case.says}")
        return
    folder = folder_of(out)
    settings = settings_of(data=folder / STORE, threads=threads)
    rows = []
    for name, row in validated(chosen, level, folder, settings, showing_progress):
        rows.append((name, row))
        if not as_json:
            print(f"{name} | {row}", flush=True)
    verdicts = Counter(row.verdict for _, row in rows)
    if as_json:
        print(json.dumps([{"case": name, **row.as_json()} for name, row in rows], indent=2, allow_nan=False))
    else:
        print(f"{verdicts['PASS']} passed, {verdicts['FAIL']} failed, {verdicts['REPORT']} reported")
        print(f"page: {folder / 'index.html'}")
    raise typer.Exit(FAILURE if verdicts["FAIL"] or not rows else SUCCESS)
