"""Cases with an exact answer: their list, and a page for each, from results that were computed once."""

import json
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from docs.pages import RESULTS, by_place, cell, counted, keep, plain, read_json, sentence, table
from solver import PHYSICS_VERSION
from studies.quantities.display import NONE, digits
from tests.cases.verification import DEFAULT
from tests.cases.verification import cases as exact_cases

STORED = RESULTS / "verification.json"
COMMAND = "python -m docs.pages compute verification"
VERDICTS = {None: "report", True: "pass", False: "fail"}

Figure = float | bool | str
KeptRow = Mapping[str, Any]
Cases = Mapping[str, Sequence[KeptRow]]


def compute(directory: Path | None = None) -> None:
    """Every verification case with the default recipe, into ``docs/results/verification.json``.

    A directory keeps the rows of each case, so that an interrupted computation goes on.
    """
    cases = {name: _rows_of(name, directory) for name in exact_cases()}
    document = {"command": COMMAND, "version": version("whipple"), "physics_version": PHYSICS_VERSION, "cases": cases}
    keep(document, STORED)


def _rows_of(name: str, directory: Path | None) -> list[dict[str, Any]]:
    file = None if directory is None else directory / f"{name}.json"
    if file is not None and file.exists():
        return list(read_json(file))
    rows = [plain(row.as_json()) for row in exact_cases()[name].run(DEFAULT)]
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(rows), encoding="utf-8")
    return rows


def pages() -> dict[str, str]:
    """The list of the cases, and a page for each."""
    cases: Cases = read_json(STORED)["cases"]
    return {
        "verification.md": _list(cases),
        **{f"verification/{name}.md": _page(name, rows) for name, rows in cases.items()},
    }


def _list(cases: Cases) -> str:
    document = read_json(STORED)
    absent = [f"`{name}`" for name in exact_cases() if name not in document["cases"]]
    longer = f" Not computed for this page: {', '.join(absent)}." if absent else ""
    return "\n".join(
        [
            "# Against exact answers\n",
            f"Computed by `{document['command']}` with version {document['version']} (physics version "
            f"{document['physics_version']}) and the default recipe; `make claims cases` computes it anew. "
            "Some rows have a gate, a tolerance that was stated before the run; the others are reported beside it. The "
            f"last column is the largest error over its tolerance.{longer}\n",
            table(
                ["case", "states", "rows", "gates held", "largest share of a tolerance"],
                [_summary(name, rows) for name, rows in cases.items()],
            ),
        ]
    )


def _summary(name: str, rows: Sequence[KeptRow]) -> list[str]:
    shares = [row["error"] / row["tolerance"] for row in rows if row.get("tolerance") and "error" in row]
    return [
        f"[{name}](verification/{name}.md)",
        exact_cases()[name].says,
        str(len(rows)),
        counted(rows),
        f"{100.0 * max(shares):.0f} %" if shares else NONE,
    ]


def _page(name: str, rows: Sequence[KeptRow]) -> str:
    case = exact_cases()[name]
    header = ["compared", "expected", "computed", "error", "tolerance", "verdict"]
    text = f"{sentence(case.says)} Source: {case.source}.\n"
    return "\n".join([f"# {name}\n", text, table(header, list(by_place([_row(row) for row in rows])))])


def _row(row: KeptRow) -> list[str]:
    texts = [_shown(row.get(column)) for column in ("expected", "got", "error", "tolerance")]
    return [cell(text) for text in (row["claim"], *texts, VERDICTS[row.get("passed")])]


def _shown(value: Figure | None) -> str:
    """A figure with four digits; a dash where there is none."""
    return NONE if value is None else digits(value, 4) if isinstance(value, float) else str(value)
