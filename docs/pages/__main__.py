"""``python -m docs.pages`` writes the made pages, ``... compute NAME`` computes the results behind one first."""

import sys
from argparse import ArgumentParser
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

from docs import pages
from docs.pages import (
    DOCS,
    failure,
    gallery,
    mesh_error,
    shield_series,
    shots,
    simulated_shields,
    tutorial,
    validation,
    verification,
)

NAMES = (found.name for found in iter_modules(pages.__path__) if found.name != "__main__")
PAGES = tuple(module for name in NAMES if hasattr(module := import_module(f"docs.pages.{name}"), "pages"))
COMPUTED = {
    "accuracy": verification,
    "failure": failure,
    "gallery": gallery,
    "mesh-error": mesh_error,
    "shield-series": shield_series,
    "shots": shots,
    "simulated-shields": simulated_shields,
    "tutorial": tutorial,
    "validation": validation,
}


def main(arguments: list[str]) -> None:
    """Compute results where asked to, then write every page and drawing."""
    asked = _parser().parse_args(arguments)
    if asked.command:
        # A directory of the computation, which then resumes, and names of cases.
        COMPUTED[asked.name].compute(*map(Path, asked.rest))
    for module in PAGES:
        for file, text in module.pages().items():
            (DOCS / file).parent.mkdir(exist_ok=True)
            (DOCS / file).write_text(text, encoding="utf-8")
        for file, text in module.drawings().items() if hasattr(module, "drawings") else ():
            (DOCS / "drawings" / file).write_text(text, encoding="utf-8")
    limits = DOCS / "limits.md"
    lines = limits.read_text(encoding="utf-8").splitlines()
    lines = [shots.limit() if line.startswith(shots.LIMIT) else line for line in lines]
    limits.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _parser() -> ArgumentParser:
    parser = ArgumentParser("python -m docs.pages", description="Write the made pages of docs/.")
    commands = parser.add_subparsers(dest="command", metavar="compute")
    compute = commands.add_parser("compute", help="compute the results behind a page first")
    compute.add_argument("name", choices=COMPUTED)
    compute.add_argument(
        "rest",
        nargs="*",
        metavar="DIRECTORY [CASE]",
        help="keeps what is computed, so that the command resumes; cases of a validation, or series; all by default",
    )
    return parser


if __name__ == "__main__":
    main(sys.argv[1:])
