"""Cases with an exact answer: their list, and a page for each, from results that were computed once."""

import json
import math
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from docs.pages import RESULTS, by_place, cell, counted, keep, plain, read_json, row_of, sentence, table
from solver import PHYSICS_VERSION
from studies.cases import verification
from studies.cases.pages import shown
from studies.cases.rows import Row
from studies.quantities.display import NONE

STORED = RESULTS / "verification.json"
COMMAND = "python -m docs.pages compute verification"


def compute(directory: Path | None = None) -> None:
    """Every verification case with the default recipe, into ``docs/results/verification.json``.

    A directory keeps the rows of each case, so that an interrupted computation goes on.
    """
    cases = {name: _rows_of(name, directory) for name in verification.names()}
    document = {"command": COMMAND, "version": version("whipple"), "physics_version": PHYSICS_VERSION, "cases": cases}
    keep(document, STORED)


def _rows_of(name: str, directory: Path | None) -> list[dict[str, Any]]:
    file = None if directory is None else directory / f"{name}.json"
    if file is not None and file.exists():
        return list(read_json(file))
    rows = [plain(verified.row) for verified in verification.verify([name])]
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(rows), encoding="utf-8")
    return rows


def pages() -> dict[str, str]:
    """The list of the cases, and a page for each."""
    cases = {name: [row_of(row) for row in rows] for name, rows in read_json(STORED)["cases"].items()}
    return {
        "verification.md": _list(cases),
        **{f"verification/{name}.md": _page(name, rows) for name, rows in cases.items()},
    }


def _list(cases: dict[str, list[Row]]) -> str:
    document = read_json(STORED)
    absent = [f"`{name}`" for name in verification.names() if name not in document["cases"]]
    longer = f" Not computed for this page: {', '.join(absent)}." if absent else ""
    return "\n".join(
        [
            "# Against exact answers\n",
            f"Computed by `{document['command']}` with version {document['version']} (physics version "
            f"{document['physics_version']}) and the default recipe; `whipple validate verification` computes it anew. "
            "Some rows have a gate, a tolerance that was stated before the run; the others are reported beside it. The "
            f"last column is the largest error over its tolerance.{longer}\n",
            table(
                ["case", "states", "rows", "gates held", "largest share of a tolerance"],
                [_summary(name, rows) for name, rows in cases.items()],
            ),
        ]
    )


def _summary(name: str, rows: Sequence[Row]) -> list[str]:
    shares = [row.error / row.tolerance for row in rows if row.tolerance and not math.isnan(row.error)]
    return [
        f"[{name}](verification/{name}.md)",
        verification.load(name).says,
        str(len(rows)),
        counted(rows),
        f"{100.0 * max(shares):.0f} %" if shares else NONE,
    ]


def _page(name: str, rows: Sequence[Row]) -> str:
    case = verification.load(name)
    header = ["compared", "expected", "computed", "error", "tolerance", "verdict"]
    text = f"{sentence(case.says)} Source: {case.source}.\n"
    return "\n".join([f"# {name}\n", text, table(header, list(by_place([_row(row) for row in rows])))])


def _row(row: Row) -> list[str]:
    cells = map(shown, (row.expected, row.got, row.error, row.tolerance))
    return [cell(each) for each in (row.claim, *cells, row.verdict.lower())]
