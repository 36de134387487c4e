"""docs/accuracy.md: how accurate the solver is, from verification and validation results that were computed once."""

import json
from importlib.metadata import version
from pathlib import Path
from typing import Any

from docs.pages import MADE, RESULTS, keep, shots, table
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
    kept = None if directory is None else directory / f"{name}.json"
    if kept is not None and kept.exists():
        rows: list[dict[str, Any]] = json.loads(kept.read_text(encoding="utf-8"))
        return rows
    rows = [verified.row.as_json() for verified in verification.verify([name])]
    if kept is not None:
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(json.dumps(rows), encoding="utf-8")
    return rows


def stored() -> dict[str, Any]:
    """The results as they were computed."""
    document: dict[str, Any] = json.loads(STORED.read_text(encoding="utf-8"))
    return document


def page() -> str:
    """docs/accuracy.md."""
    document = stored()
    absent = [f"`{name}`" for name in verification.names() if name not in document["cases"]]
    longer = f" Longer cases, which the table does not have: {', '.join(absent)}." if absent else ""
    parts = [
        "# How accurate is it\n",
        MADE.format(source=f"`docs/results/{STORED.name}` and `studies/observations/{shots.STORED.name}`"),
        "Three kinds of evidence: problems with an exact answer (here), [published shots](shots.md), and the error "
        "bar of each result, from its own resolutions and offsets (`accuracy: standard` or `fine`).\n",
        "## Against experiments\n",
        shots.summary(shots.stored()["shots"]),
        "## Against exact answers\n",
        f"Computed by `{document['command']}` with version {document['version']} (physics version "
        f"{document['physics_version']}) and the default recipe. `whipple validate verification` prints every row; a "
        "row that is reported has no gate. The largest share is the largest error over its tolerance." + longer + "\n",
        table(
            ["case", "states", "rows", "passed", "reported", "largest share of a tolerance"],
            [_summary(name, rows) for name, rows in document["cases"].items()],
        ),
    ]
    for name, rows in document["cases"].items():
        case = verification.load(name)
        parts += [
            f"### {name}\n",
            f"{case.says[0].upper()}{case.says[1:]}. Source: {case.source}.\n",
            table(["compared", "expected", "computed", "error", "tolerance", "verdict"], [_row(row) for row in rows]),
        ]
    return "\n".join(parts)


def drawings() -> dict[str, str]:
    """None of its own."""
    return {}


def _summary(name: str, rows: list[dict[str, Any]]) -> list[str]:
    verdicts = [row["verdict"] for row in rows]
    shares = [row["error"] / row["tolerance"] for row in rows if row["tolerance"] and row["error"] is not None]
    return [
        f"[{name}](#{name})",
        verification.load(name).says,
        str(len(rows)),
        str(verdicts.count("PASS")),
        str(verdicts.count("REPORT")),
        f"{100.0 * max(shares):.0f} %" if shares else NONE,
    ]


def _row(row: dict[str, Any]) -> list[str]:
    cells = [row["claim"], *(_shown(row[key]) for key in ("expected", "got", "error", "tolerance"))]
    return [cell.replace("|", "\\|") for cell in (*cells, row["verdict"].lower())]


def _shown(value: Any) -> str:
    if isinstance(value, float):
        return digits(value, 4)
    return NONE if value in (None, "") else str(value)
