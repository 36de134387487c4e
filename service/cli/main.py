"""The command ``whipple``: sweeps on this machine, the service, and the same sweeps given to a service.

Exit status: 0 all fine, 1 something went wrong, 2 the input is refused, 3 some runs failed.
"""

import sys
from typing import NoReturn

import typer

from service.cli.commands import asking, computing, keeping, serving
from service.cli.commands.options import REFUSED, WRONG
from solver.errors import WhippleError
from studies.values.errors import InvalidInput

app = typer.Typer(
    name="whipple",
    help="Hypervelocity impact: sweeps in, cubes and law reports out.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
for part in (computing, serving, asking, keeping):
    app.add_typer(part.app)


def main() -> NoReturn:
    """Run the command; whatever goes wrong is said in words."""
    try:
        app()
    except InvalidInput as error:
        from service.cli.console import print_findings

        print_findings(error)
        sys.exit(REFUSED)
    except WhippleError as error:
        print(f"whipple: {error}", file=sys.stderr)
    sys.exit(WRONG)
