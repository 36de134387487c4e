"""The command ``whipple``: sweeps on this machine, the service, and requests to a service.

Exit status: 0 success, 1 failure, 2 invalid input, 3 some runs failed.
"""

import sys
from collections.abc import Mapping
from typing import Annotated, NoReturn

import typer

from service import version
from service.cli.commands import PANELS, Commands
from service.cli.console import print_findings, say
from service.cli.options import FAILURE, INVALID
from solver.errors import WhippleError
from solver.registry import entries
from studies.quantities.findings import InvalidInput

app = typer.Typer(
    name="whipple",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
_ALL: Mapping[str, Commands] = entries("service.cli.commands", "COMMANDS")
for part in sorted(_ALL.values(), key=lambda part: (PANELS.index(part.panel), part.place)):
    for command in part.app.registered_commands:
        command.rich_help_panel = part.panel
    for group in part.app.registered_groups:
        group.rich_help_panel = part.panel
    app.add_typer(part.app)


def _print_version(asked: bool) -> None:
    if asked:
        print(version())
        raise typer.Exit


@app.callback()
def whipple(
    _version: Annotated[
        bool, typer.Option("--version", help="Print the version.", callback=_print_version, is_eager=True)
    ] = False,
) -> None:
    """Compute sweeps of hypervelocity impacts, and compare the results with published laws."""


def main() -> NoReturn:
    """Run the command, and report an error in one sentence."""
    try:
        app()
    except InvalidInput as error:
        print_findings(error)
        sys.exit(INVALID)
    except WhippleError as error:
        say(f"whipple: {error}", file=sys.stderr)
    sys.exit(FAILURE)
