"""Output folders: each holds the cube and report of one sweep, which another sweep replaces on request only.

Two documents are the same sweep if they agree in scenario, fixed parameters (a single resolution is one), accuracy,
materials of their own, and in the names of their axes. The values on the axes may differ, and so may name,
title and observations: points are added and removed, and a report is made anew.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from studies.quantities.files import REPORT_JSON
from studies.quantities.findings import Finding, InvalidInput, shown

ALIKE = ("scenario", "combine", "accuracy", "materials")  # parts of a document that agree for the same sweep
NAMED = 3  # differences that an error names


def held_in(folder: Path) -> Mapping[str, Any] | None:
    """The sweep whose report is in a folder; None without such a report."""
    try:
        held = json.loads((folder / REPORT_JSON).read_bytes())["provenance"]["sweep"]
    except (OSError, ValueError, LookupError, TypeError):
        return None
    return held if isinstance(held, Mapping) else None


def check_same(folder: Path, held: Mapping[str, Any], asked: Mapping[str, Any]) -> None:
    """Raise InvalidInput, with both names, unless a folder holds the requested sweep."""
    there, here = _question(held), _question(asked)
    differing = [name for name in {**there, **here} if there.get(name) != here.get(name)]
    if differing:
        cure = "choose another folder, or replace its content: --overwrite, overwrite=True in Python"
        value = f"{folder}, which holds {_named(held, there, differing)}"
        limit = f"an empty folder, or one that holds {_named(asked, here, differing)}"
        raise InvalidInput([Finding("out", value, limit, cure)])


def _question(document: Mapping[str, Any]) -> dict[str, Any]:
    """The values that agree for the same sweep, by name."""
    question = {name: document[name] for name in ALIKE if name in document}
    question |= {f"fixed.{name}": value for name, value in document.get("fixed", {}).items()}
    axes = {*document.get("axes", {}), *(["offset"] if "offsets" in document else [])}
    resolution = document.get("resolution")
    if isinstance(resolution, list):
        axes.add("resolution")
    elif resolution is not None:
        question["resolution"] = resolution
    return {**question, "axes": ", ".join(sorted(axes))}


def _named(document: Mapping[str, Any], question: Mapping[str, Any], differing: list[str]) -> str:
    """A sweep by its name, and by values that differ from the other one."""
    differences = (f"{name}: {_plain(question.get(name))}" for name in differing[:NAMED])
    return f"{document.get('name')!r} ({'; '.join(differences)})"


def _plain(value: Any) -> str:
    return value if isinstance(value, str) else "none" if value is None else shown(value)
