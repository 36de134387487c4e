"""docs/validation.md and a page for each published problem, on three grids beside experiments and other codes,
computed once.

A case that is another model on the mesh of its source, as the half model of a block, may stand there twice.
"""

import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

from docs.pages import DOCS, MADE, RESULTS, by_place, cell, counted, keep, read_json, sentence, table
from solver import PHYSICS_VERSION
from studies.cases import validation
from studies.cases.pages import HEADERS, cells
from studies.cases.rows import Row
from studies.quantities.display import MESH_UNKNOWN

STORED = RESULTS / "validation.json"
COMMAND = "python -m docs.pages compute validation"
LEVEL: validation.ValidationLevel = "fine"


def compute(directory: Path | None = None, *names: Path) -> None:
    """Cases (all, or some by name) into ``docs/results/validation.json``; a directory that is kept resumes.

    ``CASE`` is computed at the level ``fine``, ``CASE/thesis`` on the mesh of its source.
    """
    with tempfile.TemporaryDirectory() as temporary:
        place = directory or Path(temporary)
        chosen = [str(name) for name in names] or validation.names()
        cases = {**(read_json(STORED)["cases"] if STORED.exists() else {})}
        cases |= {name: _computed(name, place) for name in chosen}
    document = {"command": COMMAND, "version": version("whipple"), "cases": dict(sorted(cases.items()))}
    keep(document, STORED)


@contextmanager
def _unwatched(name: str) -> Iterator[Any]:
    yield lambda status: None


def _computed(chosen: str, place: Path) -> dict[str, Any]:
    """Rows of a case, and the names of its pictures, which are copied at the level ``fine``."""
    from service.cli.validation import STORE, selected, validated
    from service.settings import Settings

    settings = Settings(data=place / STORE)
    name, level = _place(chosen)
    cases = selected([name], level)
    rows = [each.row.as_json() for each in validated(cases, level, place, settings, _unwatched)]
    pictures: list[str] = []
    for file in sorted((place / name).glob("*.svg")) if level == LEVEL else []:
        pictures.append(f"validation-{file.name}")
        shutil.copy(file, DOCS / "drawings" / pictures[-1])
    return {"physics_version": PHYSICS_VERSION, "rows": rows, "pictures": pictures}


def _place(chosen: str) -> tuple[str, validation.ValidationLevel]:
    """Name and level of what stands in the results as ``CASE`` or ``CASE/LEVEL``."""
    name, _, level = chosen.partition("/")
    return name, level or LEVEL  # type: ignore[return-value]


def pages() -> dict[str, str]:
    """The list of the cases, and a page for each."""
    document = read_json(STORED)
    made = MADE.format(source=f"`docs/results/{STORED.name}`")
    absent = [f"`{name}`" for name in validation.names() if name not in document["cases"]]
    longer = f" Not computed for this page: {', '.join(absent)}." if absent else ""
    physics = " and ".join(sorted({str(kept["physics_version"]) for kept in document["cases"].values()}, key=int))
    parts = [
        "# Published problems\n",
        made,
        "Published problems, each computed as an ordinary sweep, with experiments and other codes beside. "
        "`whipple validate CASE --level quick|thesis|fine` computes one anew. A gate belongs to the mesh of the "
        "source; the value without a mesh stands beside it with its error bar, because part of a published "
        f"agreement is its mesh. A value of one grid has no error bar: {MESH_UNKNOWN}. Nothing is tuned.\n",
        # Measured 2026-11-23 on two busy cores.
        "All cases at the level `thesis` took 26 minutes of a core, nearly all of them Tables 3.3 and 3.4 in three "
        "dimensions; without `hole-laws` and `shape-coefficient`.\n",
        f"Computed by `{document['command']}` with version {document['version']} (physics version {physics}, said on "
        f"each page), level `{LEVEL}`.{longer}\n",
        table(["case", "states", "rows", "gates held"], [_summary(*each) for each in document["cases"].items()]),
    ]
    cases = [name for name in document["cases"] if _place(name)[1] == LEVEL]
    return {"validation.md": "\n".join(parts), **{f"validation/{name}.md": _page(name, made) for name in cases}}


def _summary(chosen: str, kept: dict[str, Any]) -> list[str]:
    name, level = _place(chosen)
    states = validation.load(name).says if level == LEVEL else f"the same, level {level}"
    anchor = "" if level == LEVEL else f"#level-{level}"
    return [f"[{chosen}](validation/{name}.md{anchor})", states, str(len(kept["rows"])), counted(kept["rows"])]


def _page(name: str, made: str) -> str:
    """A case at the level ``fine``, and below it at others."""
    case, cases = validation.load(name), read_json(STORED)["cases"]
    parts = [f"# {name}\n", made, f"{sentence(case.says)} Source: {case.source}.\n"]
    for chosen, kept in cases.items():
        if _place(chosen)[0] == name:
            parts += [
                *([] if chosen == name else [f"## Level {_place(chosen)[1]}\n"]),
                f"Physics version {kept['physics_version']}.\n",
                *(f"![{_title(file)}](../drawings/{file})\n" for file in kept["pictures"]),
                table(list(HEADERS), list(by_place([_row(row) for row in kept["rows"]]))),
            ]
    return "\n".join(parts)


def _title(file: str) -> str:
    return file.removeprefix("validation-").removesuffix(".svg").replace("-", " ").replace("_", " ")


def _row(row: dict[str, Any]) -> list[str]:
    kept = {name: value for name, value in row.items() if name != "verdict"}
    return [cell(each) for each in cells(Row(**kept))]
