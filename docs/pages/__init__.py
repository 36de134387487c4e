"""The pages of docs/ that a command makes, from what the project ships and from results that were computed once.

``python -m docs.pages`` writes all of them, in seconds. ``python -m docs.pages compute shots`` (or ``accuracy``)
computes the results behind a page anew, into ``docs/results/``; that takes minutes to hours.

How to add a page: a module here that offers ``pages()``, Markdown by name of file in docs/, and ``drawings()``, SVG by
name of file; and a line in ``__main__``.
"""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

DOCS = Path(__file__).parents[1]
RESULTS = DOCS / "results"
MADE = "<!-- made by `python -m docs.pages` from {source} -->\n"


def table(header: list[str], rows: list[list[str]]) -> str:
    """A table of Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines) + "\n"


def keep(document: dict[str, Any], file: Path) -> None:
    """Write results, each innermost object on a line of its own."""
    text = json.dumps(document, indent=1, ensure_ascii=False)
    innermost = re.compile(r"\{[^{}]*(?:\{[^{}]*\}[^{}]*)?\}")
    lines = innermost.sub(lambda match: re.sub(r"\n\s*", " ", match[0]), text)
    file.parent.mkdir(exist_ok=True)
    file.write_text(lines + "\n", encoding="utf-8")


def sentence(words: str) -> str:
    """Words as a sentence."""
    return f"{words[0].upper()}{words[1:]}."


def cell(text: str) -> str:
    """A text in a table of Markdown."""
    return text.replace("|", "\\|")


def counted(rows: Sequence[Mapping[str, Any]]) -> str:
    """How many of the gates of compared rows hold."""
    gates = [row["passed"] for row in rows if row["passed"] is not None]
    return f"{sum(gates)} of {len(gates)}" if gates else "no"
