"""docs/verification.md and a page for each case with an exact answer, from results that were computed once."""

import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

from docs.pages import MADE, RESULTS, by_place, cell, counted, keep, read_json, sentence, table
from solver import PHYSICS_VERSION
from studies.cases import verification
from studies.quantities.display import NONE, digits

STORED = RESULTS / "verification.json"
COMMAND = "python -m docs.pages compute accuracy"


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
    rows = [verified.row.as_json() for verified in verification.verify([name])]
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(rows), encoding="utf-8")
    return rows


def pages() -> dict[str, str]:
    """The list of the cases, and a page for each."""
    cases = read_json(STORED)["cases"]
    made = MADE.format(source=f"`docs/results/{STORED.name}`")
    return {
        "verification.md": _list(made),
        **{f"verification/{name}.md": _page(name, rows, made) for name, rows in cases.items()},
    }


def _list(made: str) -> str:
    document = read_json(STORED)
    absent = [f"`{name}`" for name in verification.names() if name not in document["cases"]]
    longer = f" Not computed for this page: {', '.join(absent)}." if absent else ""
    return "\n".join(
        [
            "# Against exact answers\n",
            made,
            f"Computed by `{document['command']}` with version {document['version']} (physics version "
            f"{document['physics_version']}) and the default recipe; `whipple validate verification` computes it anew. "
            "Some rows have a gate, a tolerance that was stated before the run; the others are reported beside it. The "
            f"last column is the largest error over its tolerance.{longer}\n",
            table(
                ["case", "states", "rows", "gates held", "largest share of a tolerance"],
                [_summary(name, rows) for name, rows in document["cases"].items()],
            ),
        ]
    )


def _summary(name: str, rows: list[dict[str, Any]]) -> list[str]:
    shares = [row["error"] / row["tolerance"] for row in rows if row["tolerance"] and row["error"] is not None]
    return [
        f"[{name}](verification/{name}.md)",
        verification.load(name).says,
        str(len(rows)),
        counted(rows),
        f"{100.0 * max(shares):.0f} %" if shares else NONE,
    ]


def _page(name: str, rows: list[dict[str, Any]], made: str) -> str:
    case = verification.load(name)
    header = ["compared", "expected", "computed", "error", "tolerance", "verdict"]
    text = f"{sentence(case.says)} Source: {case.source}.\n"
    return "\n".join([f"# {name}\n", made, text, table(header, list(by_place([_row(row) for row in rows])))])


def _row(row: dict[str, Any]) -> list[str]:
    cells = [row["claim"], *(_shown(row[key]) for key in ("expected", "got", "error", "tolerance"))]
    return [cell(each) for each in (*cells, row["verdict"].lower())]


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return digits(value, 4)
    return NONE if value in (None, "") else str(value)
