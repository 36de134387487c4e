"""Published problems: their list, and a page for each, on three grids beside experiments and other codes.

A case that is another model on the mesh of its source, as the half model of a block, may stand there twice.
"""

import tempfile
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any, cast

import numpy as np

from docs.pages import RESULTS, KeptRow, by_place, cell, counted, in_markdown, keep, plain, read_json, short, table
from service.cases.validation import STORE, selected, validated
from service.settings import Settings
from solver import PHYSICS_VERSION
from studies.cases import validation
from studies.cases.compared import Line, Picture
from studies.cases.pages import HEADERS, cells, draw
from studies.cubes.opening import whole_cube
from studies.quantities.comparison import Comparison
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


def _computed(chosen: str, place: Path) -> dict[str, Any]:
    """Rows of a case, and at the level ``fine`` the numbers of its pictures."""
    settings = Settings(data=place / STORE)
    name, _, other = chosen.partition("/")
    level = cast(validation.ValidationLevel, other or LEVEL)
    showing = nullcontext(lambda status: None)
    rows = [plain(row.as_json()) for _, row in validated(selected([name]), level, place, settings, lambda _: showing)]
    case = validation.load(name)
    cubes = {sweep: whole_cube(place / name / sweep) for sweep in case.sweeps(level)}
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


def pages() -> dict[str, str]:
    """The list of the cases, and a page for each."""
    kept = read_json(STORED)
    cases = [(chosen, *chosen.partition("/")[::2], case) for chosen, case in kept["cases"].items()]
    text = in_markdown(
        "validation",
        kept=kept,
        cases=cases,
        loaded=validation.load,
        absent=[f"`{name}`" for name in validation.names() if name not in kept["cases"]],
        physics=" and ".join(sorted({str(case["physics_version"]) for case in kept["cases"].values()}, key=int)),
        level=LEVEL,
        mesh_unknown=MESH_UNKNOWN,
        counted=counted,
    )
    of_cases = {
        f"validation/{name}.md": in_markdown(
            "case",
            case=validation.load(name),
            levels=[(level, case, _table(case["rows"])) for _, of, level, case in cases if of == name],
            file_of=_file,
        )
        for _, name, other, _ in cases
        if not other
    }
    return {"validation.md": text, **of_cases}


def _table(rows: Sequence[KeptRow]) -> str:
    texts = [cells(Comparison(**{"expected": "", "got": "", **row})) for row in rows]
    return table(list(HEADERS), list(by_place([list(map(cell, row)) for row in texts])))


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
