"""Published problems: their list, and a page for each, on three grids beside experiments and other codes.

A case that is another model on the mesh of its source, as the half model of a block, may stand there twice.
"""

import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from docs.pages import RESULTS, by_place, cell, counted, keep, plain, read_json, row_of, sentence, short, table
from solver import PHYSICS_VERSION
from studies.cases import validation
from studies.cases.compared import Line, Picture
from studies.cases.pages import HEADERS, cells, draw
from studies.quantities.display import MESH_UNKNOWN

STORED = RESULTS / "validation.json"
COMMAND = "python -m docs.pages compute validation"
LEVEL: validation.ValidationLevel = "fine"
MOST_POINTS = 80  # points of a drawn curve
DRAWN = 5  # digits of these


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
    """Rows of a case, and at the level ``fine`` the numbers of its pictures."""
    from service.cases.validation import STORE, selected, validated
    from service.settings import Settings
    from studies.cubes.reading import open_cube

    settings = Settings(data=place / STORE)
    name, level = _place(chosen)
    cases = selected([name], level)
    rows = [plain(each.row) for each in validated(cases, level, place, settings, _unwatched)]
    case = validation.load(name)
    cubes = {sweep: open_cube(place / name / sweep) for sweep in case.sweeps(level)}
    pictures = [_kept(picture) for picture in case.pictures(cubes)] if level == LEVEL else []
    return {"physics_version": PHYSICS_VERSION, "rows": rows, "pictures": pictures}


def _kept(picture: Picture) -> dict[str, Any]:
    """A picture with numbers of a page's digits, and no more points on a curve than a drawing shows."""
    lines = []
    for line in picture.lines:
        points = np.array(line.points)[:, : 2 if line.joined else 3]
        if len(points) > MOST_POINTS:
            places = np.linspace(points[0, 0], points[-1, 0], MOST_POINTS)
            points = np.column_stack([places, np.interp(places, *points.T)])
        lines.append({**asdict(line), "points": [[short(each, DRAWN) for each in point] for point in points.tolist()]})
    return {**asdict(picture), "lines": lines}


def _place(chosen: str) -> tuple[str, validation.ValidationLevel]:
    """Name and level of what stands in the results as ``CASE`` or ``CASE/LEVEL``."""
    name, _, level = chosen.partition("/")
    return name, level or LEVEL  # type: ignore[return-value]


def pages() -> dict[str, str]:
    """The list of the cases, and a page for each."""
    document = read_json(STORED)
    absent = [f"`{name}`" for name in validation.names() if name not in document["cases"]]
    longer = f" Not computed for this page: {', '.join(absent)}." if absent else ""
    physics = " and ".join(sorted({str(kept["physics_version"]) for kept in document["cases"].values()}, key=int))
    parts = [
        "# Published problems\n",
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
    return {"validation.md": "\n".join(parts), **{f"validation/{name}.md": _page(name) for name in cases}}


def drawings() -> dict[str, str]:
    """The pictures of the cases."""
    kept = [picture for case in read_json(STORED)["cases"].values() for picture in case["pictures"]]
    return {_file(picture): draw(_picture(picture)) for picture in kept}


def _file(picture: Mapping[str, Any]) -> str:
    return f"validation-{picture['name']}.svg"


def _picture(kept: Mapping[str, Any]) -> Picture:
    """A picture as it was kept."""
    lines = tuple(
        Line(each["label"], tuple((*point, 0.0)[:3] for point in each["points"]), each["joined"])
        for each in kept["lines"]
    )
    return Picture(**{**kept, "lines": lines})


def _summary(chosen: str, kept: dict[str, Any]) -> list[str]:
    name, level = _place(chosen)
    states = validation.load(name).says if level == LEVEL else f"the same, level {level}"
    anchor = "" if level == LEVEL else f"#level-{level}"
    return [
        f"[{chosen}](validation/{name}.md{anchor})",
        states,
        str(len(kept["rows"])),
        counted([row_of(row) for row in kept["rows"]]),
    ]


def _page(name: str) -> str:
    """A case at the level ``fine``, and below it at others."""
    case, cases = validation.load(name), read_json(STORED)["cases"]
    parts = [f"# {name}\n", f"{sentence(case.says)} Source: {case.source}.\n"]
    for chosen, kept in cases.items():
        if _place(chosen)[0] == name:
            parts += [
                *([] if chosen == name else [f"## Level {_place(chosen)[1]}\n"]),
                f"Physics version {kept['physics_version']}.\n",
                *(f"![{picture['title']}](../drawings/{_file(picture)})\n" for picture in kept["pictures"]),
                table(list(HEADERS), list(by_place([list(map(cell, cells(row_of(row)))) for row in kept["rows"]]))),
            ]
    return "\n".join(parts)
