"""The command ``whipple``: sweeps on this machine, the service, and requests to a service.

Exit status: 0 success, 1 failure, 2 invalid input, 3 some runs failed.
"""

import sys
from typing import Annotated, NoReturn

import typer

from service.cli.commands import (
    answering,
    calibrating,
    catalogue,
    client,
    computing,
    decks,
    drawing,
    fitting,
    maintenance,
    serving,
    validating,
)
from service.cli.commands.options import FAILURE, INVALID
from service.cli.console import print_findings, say
from solver.errors import WhippleError
from studies.quantities.findings import InvalidInput

app = typer.Typer(
    name="whipple",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
PANELS = (
    ("On this machine, without a service", computing),
    ("On this machine, without a service", drawing),
    ("On this machine, without a service", decks),
    ("On this machine, without a service", validating),
    ("Out of a cube", fitting),
    ("What ships", catalogue),
    ("Measured shots", answering),
    ("Measured shots", calibrating),
    ("The service", serving),
    ("Requests to a service", client),
    ("Maintenance of a service", maintenance),
)
for title, part in PANELS:
    for entry in (*part.app.registered_commands, *part.app.registered_groups):
        entry.rich_help_panel = title
    app.add_typer(part.app)


def _print_version(asked: bool) -> None:
    if asked:
        from service import version

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
