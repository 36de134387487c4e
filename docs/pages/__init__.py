"""The pages of docs/ that a command makes, from what the project ships and from results that were computed once.

``python -m docs.pages`` writes all of them, in seconds. ``python -m docs.pages compute shots`` (or ``accuracy``)
computes the results behind a page anew, into ``docs/results/``; that takes minutes to hours.

How to add a page: a module here that offers ``page()``, its Markdown, and ``drawings()``, its SVG by name of file; and
a line in ``__main__``.
"""

from pathlib import Path

DOCS = Path(__file__).parents[1]
RESULTS = DOCS / "results"
MADE = "<!-- made by `python -m docs.pages` from {source} -->\n"


def table(header: list[str], rows: list[list[str]]) -> str:
    """A table of Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines) + "\n"
