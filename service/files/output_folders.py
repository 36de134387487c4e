"""Output folders: each holds the cube and report of one sweep, which another sweep replaces on request only.

Two documents are the same sweep if they agree in scenario, fixed parameters (a single resolution is one), accuracy,
materials of their own, and in the names of their axes. The values on the axes may differ, and so may name,
title and observations: points are added and removed, and a report is made anew.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from studies.quantities.files import REPORT_JSON
from studies.quantities.findings import Finding, InvalidInput, shown

if TYPE_CHECKING:
    from studies.quantities.parameters import Plain

ALIKE = ("scenario", "combine", "accuracy", "materials")  # parts of a document that agree for the same sweep
NAMED = 3  # differences that an error names


def held_in(folder: Path) -> "Mapping[str, Plain] | None":
    """The sweep whose report is in a folder; None without such a report."""
    try:
        held = json.loads((folder / REPORT_JSON).read_bytes())["provenance"]["sweep"]
    except (OSError, ValueError, LookupError, TypeError):
        return None
    return held if isinstance(held, Mapping) else None


def check_same(folder: Path, held: "Mapping[str, Plain]", asked: "Mapping[str, Plain]") -> None:
    """Raise InvalidInput, with both names, unless a folder holds the requested sweep."""
    there, here = _question(held), _question(asked)
    differing = [name for name in {**there, **here} if there.get(name) != here.get(name)]
    if differing:
        cure = "choose another folder, or replace its content: --overwrite, overwrite=True in Python"
        value = f"{folder}, which holds {_named(held, there, differing)}"
        limit = f"an empty folder, or one that holds {_named(asked, here, differing)}"
        raise InvalidInput([Finding("out", value, limit, cure)])


def _question(document: "Mapping[str, Plain]") -> "dict[str, Plain]":
    """The values that agree for the same sweep, by name."""
    question = {name: document[name] for name in ALIKE if name in document}
    fixed, axes, resolution = document.get("fixed"), document.get("axes"), document.get("resolution")
    question |= {f"fixed.{name}": value for name, value in fixed.items()} if isinstance(fixed, Mapping) else {}
    names = {*axes} if isinstance(axes, Mapping) else set()
    names |= {"offset"} if "offsets" in document else set()
    if isinstance(resolution, list):
        names.add("resolution")
    elif resolution is not None:
        question["resolution"] = resolution
    return {**question, "axes": ", ".join(sorted(names))}


def _named(document: "Mapping[str, Plain]", question: "Mapping[str, Plain]", differing: list[str]) -> str:
    """A sweep by its name, and by values that differ from the other one."""
    values = [(name, question.get(name, "none")) for name in differing[:NAMED]]
    differences = (f"{name}: {value if isinstance(value, str) else shown(value)}" for name, value in values)
    return f"{document.get('name')!r} ({'; '.join(differences)})"
