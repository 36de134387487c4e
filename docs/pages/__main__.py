"""``python -m docs.pages compute NAME`` computes the results behind a made page anew."""

import sys
from argparse import ArgumentParser
from pathlib import Path

from docs.pages import modules

# By the name of a page: one that has results behind it offers ``compute``.
COMPUTED = {name.replace("_", "-"): page for name, page in modules().items() if hasattr(page, "compute")}


def main(arguments: list[str]) -> None:
    """Compute results."""
    parser = ArgumentParser("python -m docs.pages", description="Compute the results behind the pages that are made.")
    commands = parser.add_subparsers(required=True, metavar="compute")
    compute = commands.add_parser("compute", help="compute the results behind a page")
    compute.add_argument("name", choices=COMPUTED)
    compute.add_argument(
        "rest",
        nargs="*",
        metavar="DIRECTORY [CASE]",
        help="keeps what is computed, so that the command resumes; cases of a validation; all by default",
    )
    asked = parser.parse_args(arguments)
    COMPUTED[asked.name].compute(*map(Path, asked.rest))


if __name__ == "__main__":
    main(sys.argv[1:])
