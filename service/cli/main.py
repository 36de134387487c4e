"""The command ``whipple``: sweeps on this machine, the service, and requests to a service.

Exit status: 0 success, 1 failure, 2 invalid input, 3 some runs failed.
"""

import sys
from typing import NoReturn

import typer

from service.cli.commands import client, computing, maintenance, serving
from service.cli.commands.options import FAILURE, INVALID
from solver.errors import WhippleError
from studies.values.errors import InvalidInput

app = typer.Typer(
    name="whipple",
    help="Compute sweeps of hypervelocity impacts, and compare the results with published laws.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for part in (computing, serving, client, maintenance):
    app.add_typer(part.app)


def main() -> NoReturn:
    """Run the command, and report an error in one sentence."""
    try:
        app()
    except InvalidInput as error:
        from service.cli.console import print_findings

        print_findings(error)
        sys.exit(INVALID)
    except WhippleError as error:
        print(f"whipple: {error}", file=sys.stderr)
    sys.exit(FAILURE)
