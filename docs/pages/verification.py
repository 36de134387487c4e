"""Cases with an exact answer: their list, and a page for each, from results that were computed once."""

import json
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path

from docs.pages import RESULTS, KeptRow, by_place, cell, counted, in_markdown, keep, plain, read_json, table
from solver import PHYSICS_VERSION
from studies.quantities.display import NONE, digits
from tests.cases.verification import DEFAULT, cases

STORED = RESULTS / "verification.json"
COMMAND = "python -m docs.pages compute verification"
HEADER = ["compared", "expected", "computed", "error", "tolerance", "verdict"]
VERDICTS = {None: "report", True: "pass", False: "fail"}


def compute(directory: Path | None = None) -> None:
    """Every problem with the default recipe, into ``docs/results/verification.json``.

    A directory keeps the rows of each, so that an interrupted computation goes on.
    """
    rows = {name: _rows_of(name, directory) for name in cases()}
    keep({"command": COMMAND, "version": version("whipple"), "physics_version": PHYSICS_VERSION, "cases": rows}, STORED)


def _rows_of(name: str, directory: Path | None) -> list[KeptRow]:
    file = None if directory is None else directory / f"{name}.json"
    if file is not None and file.exists():
        return list(read_json(file))
    rows = [plain(row.as_json()) for row in cases()[name].run(DEFAULT)]
    if file is not None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(rows), encoding="utf-8")
    return rows


def pages() -> dict[str, str]:
    """The list of the cases, and a page for each."""
    kept, known = read_json(STORED), cases()
    absent = [f"`{name}`" for name in known if name not in kept["cases"]]
    text = in_markdown("verification", kept=kept, cases=known, absent=absent, counted=counted, share=_largest_share)
    of_cases = {
        f"verification/{name}.md": in_markdown("case", case=known[name], levels=[("", {}, _table(rows))])
        for name, rows in kept["cases"].items()
    }
    return {"verification.md": text, **of_cases}


def _largest_share(rows: Sequence[KeptRow]) -> str:
    """The largest error over its tolerance."""
    shares = [row["error"] / row["tolerance"] for row in rows if row.get("tolerance") and "error" in row]
    return f"{100.0 * max(shares):.0f} %" if shares else NONE


def _table(rows: Sequence[KeptRow]) -> str:
    columns = ("expected", "got", "error", "tolerance")
    texts = [[row["claim"], *(shown(row.get(name)) for name in columns), VERDICTS[row.get("passed")]] for row in rows]
    return table(HEADER, list(by_place([list(map(cell, row)) for row in texts])))


def shown(value: float | str | None) -> str:
    """A figure with four digits; a dash where there is none."""
    return NONE if value is None else digits(value, 4) if isinstance(value, float) else str(value)
