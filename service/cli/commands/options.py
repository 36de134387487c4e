"""What several commands share: exit status, options, and what is made of them."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from studies.values.errors import Finding, InvalidInput

if TYPE_CHECKING:
    from service.client.client import Client
    from service.records.settings import Settings

FINE, WRONG, REFUSED, SOME_FAILED = 0, 1, 2, 3
LOCAL = "http://127.0.0.1:8000"

Out = Annotated[Path, typer.Option(help="Folder for cube.nc, report.html and report.json.")]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace another sweep that the folder holds.")
]
Threads = Annotated[
    str | None,
    typer.Option(
        metavar="auto|N",
        help="Threads of a run; by default (auto) cores that no other run takes. No result depends on them.",
    ),
]
Url = Annotated[str, typer.Option(envvar="WHIPPLE_SERVICE", help="Address of the service.")]
KeyFile = Annotated[
    Path | None,
    typer.Option(
        help="File with the API key; else WHIPPLE_API_KEY. On its own machine none is needed."
    ),
]
SweepFile = Annotated[Path, typer.Argument(metavar="FILE", help="A sweep document (YAML or JSON).")]
SweepId = Annotated[str, typer.Argument(metavar="ID", help="What submit printed.")]
RunId = Annotated[str, typer.Argument(metavar="RUN", help="What `whipple runs` printed.")]
Data = Annotated[
    Path | None, typer.Option(help="Folder of database and results; else WHIPPLE_DATA.")
]
DatabaseUrl = Annotated[
    str | None,
    typer.Option(help="Database; one with a password is better given as WHIPPLE_DATABASE_URL."),
]


def client_of(url: str, key_file: Path | None) -> "Client":
    """A client, with the key that the person has; raises InvalidInput."""
    from service.client.client import Client

    return Client(url, key=None if key_file is None else _key_in(key_file))


def settings_of(**given: Any) -> "Settings":
    """Settings from the environment and the options that were given; raises InvalidInput."""
    from pydantic import ValidationError

    from service.records.settings import Settings

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


def folder_of(out: Path) -> Path:
    """The folder, made if it is missing; raises InvalidInput."""
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        cure = f"choose another one: {error.strerror}"
        raise InvalidInput(
            [Finding("--out", str(out), "a folder that can be made", cure)]
        ) from None
    return out


def _key_in(file: Path) -> str:
    """The key in a file; raises InvalidInput, and never shows what is in there."""
    limit = "a file with an API key in it"
    try:
        words = file.read_text(encoding="utf-8").split()
    except (OSError, UnicodeError) as error:
        cure = f"correct the path: {getattr(error, 'strerror', None) or 'it is no text'}"
        raise InvalidInput([Finding("--key-file", str(file), limit, cure)]) from None
    if len(words) != 1 or not words[0].isascii():
        cure = "put into it what `whipple keys create` printed, and nothing else"
        raise InvalidInput([Finding("--key-file", str(file), limit, cure)])
    return words[0]
