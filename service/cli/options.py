"""Exit statuses and options that several commands share, and the objects made from them."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from studies.quantities.findings import Finding, InvalidInput, refusal
from studies.quantities.parameters import Plain
from studies.sweeps import document as sweep_document
from studies.sweeps.document import read_law_file

if TYPE_CHECKING:
    from service.records.jobs import SweepStatus
    from service.settings import Settings

SUCCESS, FAILURE, INVALID, SOME_FAILED = 0, 1, 2, 3

Out = Annotated[Path, typer.Option(help="Folder for cube.nc, runs.csv, report.html, appendix.html and report.json.")]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace another sweep in the folder.")]
EveryColumn = Annotated[
    bool, typer.Option("--all", help="Write every column into runs.csv: all results, parameters and the audit too.")
]
Threads = Annotated[
    str | None,
    typer.Option(
        metavar="auto|N",
        help="Threads of a run; auto (default) uses cores that no other run needs. Results are independent of it.",
    ),
]
KeepOption = Annotated[str, typer.Option(help="Files kept for each run: numbers, also the final state, also the film.")]
SweepFile = Annotated[Path, typer.Argument(metavar="FILE", help="A sweep document (YAML or JSON).")]
Laws = Annotated[
    list[Path] | None,
    typer.Option("--law", metavar="FILE", help="A law that `whipple fit` wrote, to compare too; repeatable."),
]
Accuracy = Annotated[
    str | None,
    typer.Option(
        metavar="3%|draft|standard|fine",
        help="Mesh error of what is measured, in place of the resolution and the offsets of the file.",
    ),
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON, in SI units, for programs.")]
Data = Annotated[Path | None, typer.Option(help="Folder of database and results; default WHIPPLE_DATA.")]


def document_of(file: Path, laws: list[Path] | None = None, accuracy: str | None = None) -> dict[str, Plain]:
    """The document of a sweep, with the content of the files of fitted laws, at an accuracy; raises InvalidInput."""
    document = sweep_document.document_of(file, accuracy=accuracy)
    if laws:
        own = document.get("laws") or []
        document["laws"] = [*own, *map(read_law_file, laws)] if isinstance(own, list) else own
    return document


def settings_of(**options: Path | str | int | None) -> "Settings":
    """Settings from the environment and the options that are not None; raises InvalidInput."""
    from pydantic import ValidationError

    from service.settings import Settings

    try:
        return Settings.model_validate({name: value for name, value in options.items() if value is not None})
    except ValidationError as error:
        cure = "correct the option, or WHIPPLE_* in the environment"
        raise InvalidInput(
            Finding(".".join(map(str, item["loc"])), str(item["input"]), item["msg"], cure) for item in error.errors()
        ) from None


def folder_of(out: Path) -> Path:
    """The folder, created if it is missing; raises InvalidInput."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise refusal("--out", str(out), "a folder", f"choose another folder: {error.strerror}") from None
    return out


def exit_status(ended: "SweepStatus") -> int:
    """The exit status for a sweep that has ended."""
    if ended.state == "failed":
        return FAILURE
    return SUCCESS if ended.counts.get("succeeded") == ended.planned else SOME_FAILED
