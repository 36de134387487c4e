"""Published and exactly solved problems, computed here and compared."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from service.cli.commands import LOCAL, Commands
from service.cli.options import FAILURE, SUCCESS, Json, Threads, folder_of, settings_of
from studies.quantities.findings import refusal

if TYPE_CHECKING:
    from studies.cases.validation import ValidationLevel

app = typer.Typer()
COMMANDS = Commands("cases", LOCAL, app, place=3)

Cases = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[CASE ...]",
        help="Cases; `validation` or `verification` are all of the published or of the exactly solved ones.",
    ),
]
DetailLevel = Annotated[
    str,
    typer.Option(
        "--level",
        metavar="quick|thesis|fine",
        help="Coarse grids and short cases; the meshes of the sources; or three grids.",
    ),
]


@app.command()
def validate(
    cases: Cases = None,
    level: DetailLevel = "quick",
    out: Annotated[Path, typer.Option(metavar="DIR", help="Folder for pages, cubes and reports.")] = Path("validation"),
    threads: Threads = None,
    listing: Annotated[bool, typer.Option("--list", help="Print the cases alone.")] = False,
    as_json: Json = False,
) -> None:
    """Compute published and exactly solved problems, and compare. Repeated, it resumes."""
    from service.cases.validation import STORE, selected, validated
    from service.client.progress import showing_progress

    chosen_level = _level(level)
    chosen = selected(cases or [], chosen_level)
    if listing:
        for case in chosen:
            print(f"{case.name}: {case.says}")
        return
    folder = folder_of(out)
    settings = settings_of(data=folder / STORE, threads=threads)
    rows = []
    for each in validated(chosen, chosen_level, folder, settings, showing_progress):
        rows.append(each)
        if not as_json:
            print(f"{each.case} | {each.row}", flush=True)
    failed = sum(each.row.passed is False for each in rows)
    if as_json:
        print(json.dumps([each.as_json() for each in rows], indent=2, allow_nan=False))
    else:
        checked = sum(each.row.passed is not None for each in rows)
        print(f"{checked - failed} passed, {failed} failed, {len(rows) - checked} reported")
        print(f"pages: {folder / 'index.html'}")
    raise typer.Exit(FAILURE if failed or not rows else SUCCESS)


def _level(text: str) -> "ValidationLevel":
    from studies.cases.validation import LEVELS

    for level in LEVELS:
        if text == level:
            return level
    raise refusal("--level", text, ", ".join(LEVELS), "write one of these")
